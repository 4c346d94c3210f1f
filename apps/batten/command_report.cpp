#include "command.hpp"
#include "experiments/sketch_comparison.hpp"
#include "experiments/thesis_h.hpp"
#include "experiments/thesis_page.hpp"
#include "experiments/thesis_s.hpp"
#include "model_surface_arguments.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>
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
using experiments::ThesisOptions;
using experiments::ThesisResult;
using experiments::ThesisRow;

constexpr const char* kDefaultData = "../shared/data";
constexpr const char* kDefaultSessions = "examples/sessions";

struct ReportArguments {
  std::string experiment, output, data, sessions;
  ThesisOptions thesis;
  bool no_verdict = false;
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

/// The folder that an option names, or the usual one where that is there; else empty, with a warning.
/// @param content what lies in it.
std::string data_folder(const std::string& given, const char* option, const char* usual, const char* content,
                        Outcome& outcome) {
  std::string folder = given.empty() ? usual : given;
  if (std::filesystem::is_directory(folder)) return folder;
  if (!given.empty())
    throw FileError(folder, 0,
                    concat("there is no such folder; ", option, " names the one with the ", content));
  outcome.warnings.push_back(
      concat("there is no folder ", folder, "; name the one with the ", content, " by ", option));
  return {};
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ",") + word;
  return text;
}

Outcome run_sketch_report(const ReportArguments& arguments, Context& context) {
  Outcome outcome;
  const std::string folder = data_folder(arguments.data, "--data", kDefaultSessions, "sessions", outcome);
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

struct ThesisPage {
  const char* experiment;
  const char* title;
  std::vector<experiments::ThesisExperiment> (*rows)();
};
constexpr ThesisPage kTheses[] = {
    {"thesis-s", "Stanko's thesis, repeated", experiments::thesis_s},
    {"thesis-h", "Huska's thesis, chapter 2, repeated", experiments::thesis_h},
    {"thesis-h-fires", "Huska's thesis, chapter 7, repeated", experiments::thesis_h_fires}};

/// The page with the rows there are, whole after every one of them.
void write_thesis_page(const ReportArguments& arguments, const ThesisPage& thesis,
                       const std::vector<std::string>& warnings, const ThesisResult& found) {
  Report report;
  report.title = thesis.title;
  report.subject = arguments.thesis.data;
  report.version = BATTEN_VERSION;
  report.command_line = concat("batten report ", arguments.experiment, " -o ", arguments.output,
                               arguments.data.empty() ? "" : " --data " + arguments.data,
                               arguments.sessions.empty() ? "" : " --sessions " + arguments.sessions,
                               arguments.thesis.quick ? " --quick" : "");
  if (!arguments.thesis.rows.empty())
    report.command_line += concat(" --rows '", joined(arguments.thesis.rows), "'");
  report.warnings = warnings;
  add_rows(found, report);
  write_file(arguments.output, html(report));
}

/// "S 3.19, S 3.20".
std::string missed_ids(const std::vector<ThesisRow>& rows) {
  std::string list;
  for (const ThesisRow& row : rows)
    if (row.is_missed()) list += (list.empty() ? "" : ", ") + row.id;
  return list;
}

Outcome run_thesis_report(ReportArguments arguments, Context& context) {
  Outcome outcome;
  const ThesisPage& thesis =
      *std::find_if(std::begin(kTheses), std::end(kTheses),
                    [&](const ThesisPage& page) { return arguments.experiment == page.experiment; });
  ThesisOptions& options = arguments.thesis;
  options.data = data_folder(arguments.data, "--data", kDefaultData, "public meshes and curves", outcome);
  if (arguments.experiment == std::string("thesis-h-fires"))
    options.sessions = data_folder(arguments.sessions, "--sessions", kDefaultSessions, "sessions", outcome);
  options.pictures = !arguments.output.empty();
  const std::vector<std::string> warnings = outcome.warnings;
  experiments::ThesisRun run(options, context.progress);
  const ThesisResult found = run.run(thesis.rows(), [&](const ThesisResult& so_far) {
    if (!arguments.output.empty()) write_thesis_page(arguments, thesis, warnings, so_far);
  });
  if (found.rows.empty())
    throw InvalidInput(concat("no row of ", arguments.experiment, " begins with ", joined(options.rows),
                              "; without --rows all are made and listed"));
  const experiments::VerdictCounts counts = verdict_counts(found.rows);
  outcome.times.add(found.times);
  outcome.warnings.insert(outcome.warnings.end(), found.warnings.begin(), found.warnings.end());
  outcome.figures["experiment"] = arguments.experiment;
  outcome.figures["data"] = options.data.empty() ? Json(nullptr) : Json(options.data);
  outcome.figures["rows"] = Json::array();
  for (const ThesisRow& row : found.rows) outcome.figures["rows"].push_back(row_json(row));
  outcome.figures["counts"] = counts_json(counts);
  print(rows_grid(found), outcome.lines);
  if (!arguments.output.empty()) outcome.lines.push_back("wrote " + arguments.output);
  if (counts.misses() > 0 && !arguments.no_verdict)
    outcome.failure = concat(counts.misses(), " of ", found.rows.size(),
                             " rows miss what the thesis claims: ", missed_ids(found.rows),
                             "; --no-verdict reports them all the same and exits with 0");
  return outcome;
}

}  // namespace

void add_report(CLI::App& app) {
  auto arguments = std::make_shared<ReportArguments>();
  CLI::App* command = add_command(
      app, "report",
      "Repeat the experiments of a thesis, each with a verdict, or compare the surfaces of sketched models.",
      "batten report thesis-s --quick -o thesis-s.html --data ../shared/data", [arguments](Context& context) {
        return arguments->experiment == "sketch" ? run_sketch_report(*arguments, context)
                                                 : run_thesis_report(*arguments, context);
      });
  command
      ->add_option(
          "EXPERIMENT", arguments->experiment,
          "thesis-s: Stanko; thesis-h: Huska, chapter 2; thesis-h-fires: Huska, chapter 7; sketch: the "
          "methods of batten sketch on the same models")
      ->required()
      ->check(CLI::IsMember({"thesis-s", "thesis-h", "thesis-h-fires", "sketch"}));
  command->add_option("-o,--output", arguments->output, "HTML page to write, with pictures")
      ->check([](const std::string& path) {
        const std::string extension = output_extension(path, "html");
        return extension == "html" || extension == "htm" ? std::string()
                                                         : concat("--output must name an .html file: ", path);
      });
  command->add_option(
      "--data", arguments->data,
      concat("Folder with public meshes and curves; of sketch, with the sessions; by default ", kDefaultData,
             " and ", kDefaultSessions));
  command->add_option(
      "--sessions", arguments->sessions,
      concat("thesis-h-fires: folder with the sessions of sketches; by default ", kDefaultSessions));
  command->add_flag("--quick", arguments->thesis.quick,
                    "Theses: five seeds instead of twenty, fewer steps, small meshes");
  command
      ->add_option("--rows", arguments->thesis.rows,
                   "Theses: only rows that begin with these, joined by commas: 3.18,2.4")
      ->delimiter(',');
  command->add_flag("--no-verdict", arguments->no_verdict,
                    "Theses: exit with 0 although rows miss their claims");
  command->add_option("--methods", arguments->methods, "sketch: only these methods, joined by commas")
      ->delimiter(',')
      ->check(CLI::IsMember(choice_words<ModelSurfaceMethod>()));
  command->add_option("--models", arguments->sketch.models, "sketch: only these models, joined by commas")
      ->delimiter(',');
  command->add_option("--levels", arguments->sketch.surface.levels, "sketch: levels of subdivision, 0 to 6")
      ->check(CLI::Range(0, 6));
}

}  // namespace batten::cli
