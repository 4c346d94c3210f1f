#include "report_page.hpp"

#include <cmath>

#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/render/render.hpp"
#include "batten/report/report.hpp"

namespace batten::cli {

namespace {

struct Picture {
  Shading shading;
  const char* title;
  const char* caption;
};

constexpr Picture kMeshPictures[] = {
    {Shading::Isophotes, "Isophotes",
     "Stripes of equal slope to the light. A kink in a stripe is a kink of the surface."},
    {Shading::ReflectionLines, "Reflection lines",
     "Parallel lamps mirrored in the surface. A kink shows a break of curvature."},
    {Shading::NormalMap, "Normal map",
     "The hemisphere of normals as circles about the viewer; regular on a fair surface."},
    {Shading::MeanCurvature, "Mean curvature",
     "Half the sum of the principal curvatures, positive on a sphere."},
    {Shading::GaussianCurvature, "Gaussian curvature", "The product of the principal curvatures."},
    {Shading::Wireframe, "Wireframe", "The triangles."},
};

constexpr Picture kNetworkPictures[] = {
    {Shading::Porcupine, "Porcupine plot", "Normals along the curves, scaled by the curvature of the curve."},
    {Shading::GaussMap, "Gauss map",
     "The normals as points of the unit sphere. Curves that meet must meet here too."},
};

std::string words(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_float()) return concat(value.get<double>());
  return value.dump();
}

/// The scalars of an object as one table; objects inside it as tables of their own.
void add_tables(const std::string& title, const Json& object, std::vector<ReportTable>& tables) {
  ReportTable table{title, {}};
  std::vector<std::pair<std::string, const Json*>> inner;
  for (const auto& [key, value] : object.items()) {
    std::string name = key;
    for (char& c : name)
      if (c == '_') c = ' ';
    if (value.is_object()) {
      inner.emplace_back(name, &value);
    } else if (value.is_array()) {
      // Lists of a few numbers are figures; long ones belong to --json.
      if (value.empty() || value.size() > 12 || value.front().is_structured()) continue;
      std::string list;
      for (const Json& item : value) list += (list.empty() ? "" : ", ") + words(item);
      table.figures.push_back({name, list, ""});
    } else if (!value.is_null()) {
      table.figures.push_back({name, words(value), ""});
    }
  }
  if (!table.figures.empty()) tables.push_back(std::move(table));
  for (const auto& [name, value] : inner) add_tables(title + ": " + name, *value, tables);
}

std::string command_line(const CLI::App& command) {
  std::string line = "batten " + command.get_name();
  const auto quoted = [](const std::string& text) {
    return text.find_first_of(" '\"$&;()*?") == std::string::npos ? text : "\"" + text + "\"";
  };
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0) continue;
    if (!option->get_positional()) line += " --" + option->get_single_name();
    if (option->get_expected_max() == 0) continue;
    for (const std::string& text : option->results()) line += " " + quoted(text);
  }
  return line;
}

std::vector<ReportPicture> draw(const Exhibit& exhibit, const Progress& progress) {
  std::vector<ReportPicture> pictures;
  const auto add = [&](const Subject& subject, const Picture& picture, bool wide) {
    RenderOptions options;
    options.shading = picture.shading;
    options.width = wide ? 1200 : 800;
    options.height = wide ? 750 : 600;
    pictures.push_back(
        {picture.title, picture.caption, encode_png(render(subject, options, progress)), wide});
  };
  const TriangleMesh* mesh = exhibit.mesh ? &*exhibit.mesh : nullptr;
  const CurveNetwork* network = exhibit.network ? &*exhibit.network : nullptr;
  if (mesh != nullptr && mesh->n_triangles() == 0) mesh = nullptr;
  if (mesh == nullptr && network == nullptr) return pictures;

  Subject subject{.mesh = mesh, .network = network};
  add(subject, {Shading::Shaded, mesh != nullptr ? "The surface" : "The network", ""}, true);
  if (exhibit.errors.size() > 0) {
    subject.errors = exhibit.errors;
    subject.error_unit = "error, % of size";
    add(subject, {Shading::Error, "Distance to the truth", "In per cent of the diameter of the truth."},
        true);
  }
  if (mesh != nullptr) {
    for (const Picture& picture : kMeshPictures) add({.mesh = mesh}, picture, false);
  }
  if (network != nullptr && network->has_normals()) {
    for (const Picture& picture : kNetworkPictures) add({.network = network}, picture, false);
  }
  return pictures;
}

}  // namespace

void write_report(const std::string& path, const CLI::App& command, const Outcome& outcome,
                  const Progress& progress) {
  Report report;
  report.title = "batten " + command.get_name();
  report.version = BATTEN_VERSION;
  report.command_line = command_line(command);
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_single_name();
    if (name == "help" || name == "json" || name == "report") continue;
    const bool given = option->count() > 0;
    std::string value = option->get_default_str();
    if (option->get_expected_max() == 0) value = given ? "on" : "off";
    if (given && option->get_expected_max() != 0) {
      value.clear();
      for (const std::string& text : option->results()) value += (value.empty() ? "" : " ") + text;
    }
    if (report.subject.empty() && option->get_positional()) report.subject = value;
    report.options.push_back({name, value, !given});
  }
  add_tables("Result", outcome.figures, report.tables);
  if (outcome.exhibit.errors.size() > 0)
    report.errors = ReportErrors{outcome.exhibit.errors, "% of the diameter"};
  report.warnings = outcome.warnings;
  report.times = outcome.times;
  {
    const ScopedStage stage(report.times, "draw");
    report.pictures = draw(outcome.exhibit, progress);
  }
  write_file(path, html(report));
}

}  // namespace batten::cli
