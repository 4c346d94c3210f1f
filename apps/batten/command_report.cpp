#include "command.hpp"
#include "experiments/sketch_comparison.hpp"
#include "experiments/thesis_h.hpp"
#include "model_surface_arguments.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/io/standard_streams.hpp"

namespace batten::cli {

namespace {

using experiments::SketchComparison;
using experiments::SketchComparisonOptions;
using experiments::ThesisTables;

constexpr const char* kDefaultData = "../shared/data";
constexpr const char* kDefaultSessions = "examples/sessions";

struct ReportArguments {
  std::string experiment, output, data;
  std::vector<std::string> tables;
  std::vector<std::string> methods = choice_words<ModelSurfaceMethod>();
  SketchComparisonOptions sketch;
};

Json surface_json(const experiments::MeasuredSurface& measured) {
  if (!measured.refusal.empty()) return {{"refused", measured.refusal}};
  Json json = figures_json(measured.surface);
  json["vertices"] = measured.n_vertices;
  json["faces"] = measured.n_triangles;
  json["seconds"] = measured.seconds;
  json["warnings"] = measured.surface.warnings;
  json["deviation"] = nullptr;
  if (measured.deviation)
    json["deviation"] = {{"mean", measured.deviation->mean}, {"max", measured.deviation->max}};
  json["continuity"] = continuity_json(measured.continuity, measured.diameter);
  return json;
}

Json models_json(const SketchComparison& found) {
  Json models = Json::array();
  for (const experiments::ComparedModel& model : found.models) {
    models.push_back({{"model", model.name},
                      {"curves", model.counts.curves},
                      {"faces", model.counts.faces},
                      {"genus", model.counts.genus},
                      {"methods", Json::object()}});
    for (const experiments::MeasuredSurface& surface : model.surfaces)
      models.back()["methods"][std::string(word_of(surface.method))] = surface_json(surface);
  }
  return models;
}

/// The number of characters of UTF-8 text.
std::size_t characters(const std::string& text) {
  return std::count_if(text.begin(), text.end(),
                       [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; });
}

/// The lines of a table in columns of even width.
void print(const ReportGrid& grid, std::vector<std::string>& lines) {
  std::vector<std::size_t> widths;
  for (const std::string& column : grid.columns) widths.push_back(characters(column));
  for (const auto& row : grid.rows)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], characters(row[i]));
  const auto line = [&](const std::vector<std::string>& row) {
    std::string text;
    for (std::size_t i = 0; i < row.size(); ++i)
      text += row[i] + std::string(widths[i] - characters(row[i]) + 2, ' ');
    lines.push_back(text.substr(0, text.find_last_not_of(' ') + 1));
  };
  lines.push_back(grid.title);
  line(grid.columns);
  for (const auto& row : grid.rows) line(row);
  lines.push_back(grid.note);
  lines.emplace_back();
}

/// The folder of --data, or the usual one where that is there; else empty, with a warning.
/// @param content what lies in it.
std::string data_folder(const ReportArguments& arguments, const char* usual, const char* content,
                        Outcome& outcome) {
  std::string folder = arguments.data.empty() ? usual : arguments.data;
  if (std::filesystem::is_directory(folder)) return folder;
  if (!arguments.data.empty())
    throw FileError(folder, 0, concat("there is no such folder; --data names the one with the ", content));
  outcome.warnings.push_back(
      concat("there is no folder ", folder, "; name the one with the ", content, " by --data"));
  return {};
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ",") + word;
  return text;
}

Outcome run_sketch_report(const ReportArguments& arguments, Context& context) {
  Outcome outcome;
  const std::string folder = data_folder(arguments, kDefaultSessions, "sessions", outcome);
  SketchComparisonOptions options = arguments.sketch;
  options.pictures = !arguments.output.empty();
  for (const std::string& method : arguments.methods)
    options.methods.push_back(parse_choice<ModelSurfaceMethod>(method));
  SketchComparison found = compare_sketch_surfaces(folder, options, context.progress);
  outcome.times.add(found.times);
  outcome.warnings.insert(outcome.warnings.end(), found.warnings.begin(), found.warnings.end());
  outcome.figures["experiment"] = arguments.experiment;
  outcome.figures["data"] = folder.empty() ? Json(nullptr) : Json(folder);
  outcome.figures["models"] = models_json(found);
  print(found.grid, outcome.lines);
  if (arguments.output.empty()) return outcome;

  Report report;
  report.title = "Surfaces of sketched models compared";
  report.subject = folder;
  report.version = BATTEN_VERSION;
  report.command_line = concat("batten report sketch -o ", arguments.output,
                               arguments.data.empty() ? "" : " --data " + arguments.data);
  if (options.methods.size() < choice_words<ModelSurfaceMethod>().size())
    report.command_line += " --methods " + joined(arguments.methods);
  if (!options.models.empty()) report.command_line += " --models " + joined(options.models);
  report.command_line += concat(" --levels ", options.surface.levels);
  report.grids.push_back(std::move(found.grid));
  report.pictures = std::move(found.pictures);
  report.warnings = outcome.warnings;
  report.times = outcome.times;
  write_file(arguments.output, html(report));
  outcome.lines.push_back("wrote " + arguments.output);
  return outcome;
}

std::string missing_sentence(const ThesisTables& found) {
  std::string missing;
  for (const std::string& mesh : found.missing) missing += (missing.empty() ? "" : ", ") + mesh;
  return missing.empty() ? missing : "meshes of the thesis that are not at hand: " + missing;
}

/// The page with the tables there are, whole after every one of them.
void write_thesis_page(const ReportArguments& arguments, const std::string& folder, const ThesisTables& found,
                       std::vector<std::string> warnings) {
  Report report;
  report.title = "Huska's thesis, chapter 2, repeated";
  report.subject = folder;
  report.version = BATTEN_VERSION;
  report.command_line = concat("batten report ", arguments.experiment, " -o ", arguments.output,
                               arguments.data.empty() ? "" : " --data " + arguments.data);
  if (arguments.tables.size() < experiments::thesis_h_tables().size())
    report.command_line += " --tables " + joined(arguments.tables);
  report.grids = found.grids;
  report.pictures = found.pictures;
  report.warnings = std::move(warnings);
  report.warnings.insert(report.warnings.end(), found.warnings.begin(), found.warnings.end());
  if (const std::string missing = missing_sentence(found); !missing.empty())
    report.warnings.insert(report.warnings.begin(), missing);
  const std::vector<std::string>& all = experiments::thesis_h_tables();
  const auto wanted = std::count_if(all.begin(), all.end(), [&](const std::string& table) {
    return std::find(arguments.tables.begin(), arguments.tables.end(), table) != arguments.tables.end();
  });
  const auto left = wanted - static_cast<std::ptrdiff_t>(found.grids.size());
  if (left > 0)
    report.warnings.insert(report.warnings.begin(), concat("not finished: tables to come: ", left));
  report.times = found.times;
  write_file(arguments.output, html(report));
}

Outcome run_thesis_report(const ReportArguments& arguments, Context& context) {
  Outcome outcome;
  const std::string folder = data_folder(arguments, kDefaultData, "meshes of the thesis", outcome);
  const std::vector<std::string> warnings = outcome.warnings;
  const ThesisTables found = experiments::thesis_h(folder, arguments.tables, !arguments.output.empty(),
                                                   context.progress, [&](const ThesisTables& so_far) {
                                                     if (!arguments.output.empty())
                                                       write_thesis_page(arguments, folder, so_far, warnings);
                                                   });
  outcome.times.add(found.times);
  outcome.warnings.insert(outcome.warnings.end(), found.warnings.begin(), found.warnings.end());
  outcome.figures["experiment"] = arguments.experiment;
  outcome.figures["data"] = folder.empty() ? Json(nullptr) : Json(folder);
  outcome.figures["meshes"] = found.meshes;
  outcome.figures["missing"] = found.missing;
  outcome.figures["tables"] = found.tables;
  for (const ReportGrid& grid : found.grids) print(grid, outcome.lines);
  if (const std::string missing = missing_sentence(found); !missing.empty()) outcome.lines.push_back(missing);
  if (!arguments.output.empty()) outcome.lines.push_back("wrote " + arguments.output);
  return outcome;
}

}  // namespace

void add_report(CLI::App& app) {
  auto arguments = std::make_shared<ReportArguments>();
  arguments->tables = experiments::thesis_h_tables();
  CLI::App* command = add_command(
      app, "report", "Repeat the tables of a thesis, or compare the surfaces of sketched models.",
      "batten report thesis-h -o thesis-h.html --data ../shared/data", [arguments](Context& context) {
        return (arguments->experiment == "sketch" ? run_sketch_report : run_thesis_report)(*arguments,
                                                                                           context);
      });
  command
      ->add_option("EXPERIMENT", arguments->experiment,
                   "thesis-h: Huska, chapter 2; sketch: the methods of batten sketch on the same models")
      ->required()
      ->check(CLI::IsMember({"thesis-h", "sketch"}));
  command->add_option("-o,--output", arguments->output, "HTML page to write, with pictures")
      ->check([](const std::string& path) {
        const std::string extension = output_extension(path, "html");
        return extension == "html" || extension == "htm" ? std::string()
                                                         : concat("--output must name an .html file: ", path);
      });
  command->add_option("--data", arguments->data,
                      concat("Folder with the meshes, by their names, or with the sessions; by default ",
                             kDefaultData, " and ", kDefaultSessions));
  command->add_option("--tables", arguments->tables, "thesis-h: only these tables, joined by commas")
      ->delimiter(',')
      ->check(CLI::IsMember(experiments::thesis_h_tables()));
  command->add_option("--methods", arguments->methods, "sketch: only these methods, joined by commas")
      ->delimiter(',')
      ->check(CLI::IsMember(choice_words<ModelSurfaceMethod>()));
  command->add_option("--models", arguments->sketch.models, "sketch: only these models, joined by commas")
      ->delimiter(',');
  command->add_option("--levels", arguments->sketch.surface.levels, "sketch: levels of subdivision, 0 to 6")
      ->check(CLI::Range(0, 6));
}

}  // namespace batten::cli
