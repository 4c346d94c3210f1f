#include "thesis_run.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/mesh_io.hpp"

namespace batten::experiments {

namespace {

/// The row of an experiment that could not be finished.
ThesisRow refused_row(const std::string& id, const std::string& reason) {
  ThesisRow row;
  row.id = id;
  row.claim = "The experiment can be repeated.";
  row.decide(false);
  row.remark = reason;
  return row;
}

/// Chapter and number of an id: "S 3.18 weights" → 3, 18.
std::pair<int, int> place_in_thesis(const std::string& id) {
  int chapter = 0, number = 0;
  std::sscanf(id.c_str(), "%*s %d.%d", &chapter, &number);
  return {chapter, number};
}

}  // namespace

ThesisRun::ThesisRun(const ThesisOptions& given, const Progress& overall)
    : options(given), overall_(overall) {}

std::string ThesisRun::seeds_text(std::string_view what) const {
  return concat(what, ", seeds 1–", n_seeds());
}

bool ThesisRun::wants(const std::string& id) const {
  if (options.rows.empty()) return true;
  const std::string without_letter = id.substr(std::min(id.size(), id.find(' ') + 1));
  return std::any_of(options.rows.begin(), options.rows.end(), [&](const std::string& row) {
    return id.starts_with(row) || without_letter.starts_with(row);
  });
}

void ThesisRun::add(ThesisRow row) {
  if (wants(row.id)) rows_.push_back(std::move(row));
}

std::optional<std::string> ThesisRun::file(const std::string& name) const {
  if (options.data.empty()) return std::nullopt;
  for (const char* packed : {"", ".gz"}) {
    const std::string path = concat(options.data, "/", name, packed);
    if (std::filesystem::is_regular_file(path)) return path;
  }
  return std::nullopt;
}

const TriangleMesh* ThesisRun::mesh(const std::string& name, std::string* path) {
  auto known = meshes_.find(name);
  if (known == meshes_.end()) {
    // Files write the name in several ways: cube-hole, cube_hole, cubehole.
    std::vector<std::string> spellings = {name};
    for (const char* joint : {"_", ""}) {
      const std::size_t dash = name.find('-');
      if (dash != std::string::npos)
        spellings.push_back(name.substr(0, dash) + joint + name.substr(dash + 1));
    }
    known = meshes_.emplace(name, std::pair<std::string, std::optional<TriangleMesh>>{}).first;
    for (const char* inner : {"", "meshes/"})
      for (const std::string& spelling : spellings)
        for (const char* extension : {".ply", ".obj", ".off", ".stl"}) {
          const std::optional<std::string> found = file(concat(inner, spelling, extension));
          if (!found || known->second.second) continue;
          known->second = {*found, read_mesh(*found, &warnings)};
        }
  }
  if (path != nullptr) *path = known->second.first;
  return known->second.second ? &*known->second.second : nullptr;
}

void ThesisRun::draw(ThesisRow& row, const std::string& title, const std::string& caption,
                     const Subject& subject, const RenderOptions& how) {
  if (!options.pictures || !wants(row.id)) return;
  row.pictures.push_back({title, caption, encode_png(render(subject, how, progress)), false});
}

void ThesisRun::draw(ThesisRow& row, const std::string& title, const std::string& caption,
                     const TriangleMesh& mesh, Shading shading, double zoom) {
  RenderOptions how;
  how.shading = shading;
  how.width = 560;
  how.height = 420;
  how.view.zoom = zoom;
  if (mesh.n_triangles() > 0) draw(row, title, caption, {.mesh = &mesh}, how);
}

ThesisResult ThesisRun::run(const std::vector<ThesisExperiment>& experiments, const RowsDone& done) {
  std::vector<std::string> order;
  std::vector<const ThesisExperiment*> wanted;
  for (const ThesisExperiment& experiment : experiments) {
    const std::size_t before = order.size();
    for (const std::string& id : experiment.ids)
      if (wants(id)) order.push_back(id);
    if (order.size() > before) wanted.push_back(&experiment);
  }
  std::stable_sort(order.begin(), order.end(), [](const std::string& a, const std::string& b) {
    return place_in_thesis(a) < place_in_thesis(b);
  });
  const auto place = [&](const std::string& id) { return std::find(order.begin(), order.end(), id); };
  const auto so_far = [&] {
    ThesisResult result{rows_, {}, warnings, times};
    std::stable_sort(result.rows.begin(), result.rows.end(),
                     [&](const ThesisRow& a, const ThesisRow& b) { return place(a.id) < place(b.id); });
    for (const std::string& id : order)
      if (std::none_of(rows_.begin(), rows_.end(), [&](const ThesisRow& row) { return row.id == id; }))
        result.to_come.push_back(id);
    return result;
  };
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const auto share = [&](std::size_t k) {
      return static_cast<double>(k) / static_cast<double>(wanted.size());
    };
    const std::string& name = wanted[i]->ids.front();
    progress = overall_.part(name, share(i), share(i + 1));
    progress.report(name, 0);
    const ScopedStage stage(times, name);
    std::string reason = "the experiment has not made this row";
    try {
      wanted[i]->work(*this);
    } catch (const Cancelled&) {
      throw;
    } catch (const FileError&) {
      throw;
    } catch (const Error& error) {
      reason = error.what();
      warnings.push_back(concat(name, ": ", reason));
    }
    for (const std::string& id : wanted[i]->ids)
      if (wants(id) &&
          std::none_of(rows_.begin(), rows_.end(), [&](const ThesisRow& row) { return row.id == id; }))
        add(refused_row(id, reason));
    if (done) done(so_far());
  }
  return so_far();
}

ThesisExperiment without_data(const std::string& id, const std::string& claim, const std::string& needs) {
  return {{id}, [id, claim, needs](ThesisRun& run) {
            ThesisRow row;
            row.id = id;
            row.claim = claim;
            row.needs = needs;
            run.add(std::move(row));
          }};
}

}  // namespace batten::experiments
