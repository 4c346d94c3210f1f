#include "command.hpp"
#include "thesis_h.hpp"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"

namespace batten::cli {

namespace {

constexpr const char* kDefaultData = "../shared/data";

struct ReportArguments {
  std::string experiment, output, data;
  std::vector<std::string> tables;
};

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

std::string data_folder(const ReportArguments& arguments, Outcome& outcome) {
  const std::string folder = arguments.data.empty() ? kDefaultData : arguments.data;
  if (std::filesystem::is_directory(folder)) return folder;
  if (!arguments.data.empty())
    throw FileError(folder, 0, "there is no such folder; --data names the one with the meshes of the thesis");
  outcome.warnings.push_back(
      concat("there is no folder ", folder, "; name the one with the meshes by --data"));
  return {};
}

Outcome run_report(const ReportArguments& arguments, Context& context) {
  Outcome outcome;
  const std::string folder = data_folder(arguments, outcome);
  ThesisTables found = thesis_h(folder, arguments.tables, !arguments.output.empty(), context.progress);
  outcome.times.add(found.times);
  outcome.warnings.insert(outcome.warnings.end(), found.warnings.begin(), found.warnings.end());
  std::string missing;
  for (const std::string& mesh : found.missing) missing += (missing.empty() ? "" : ", ") + mesh;
  if (!missing.empty()) missing = "meshes of the thesis that are not at hand: " + missing;

  outcome.figures["experiment"] = arguments.experiment;
  outcome.figures["data"] = folder.empty() ? Json(nullptr) : Json(folder);
  outcome.figures["meshes"] = found.meshes;
  outcome.figures["missing"] = found.missing;
  outcome.figures["tables"] = found.tables;
  for (const ReportGrid& grid : found.grids) print(grid, outcome.lines);
  if (!missing.empty()) outcome.lines.push_back(missing);
  if (arguments.output.empty()) return outcome;

  Report report;
  report.title = "Huska's thesis, chapter 2, repeated";
  report.subject = folder;
  report.version = BATTEN_VERSION;
  report.command_line = concat("batten report ", arguments.experiment, " -o ", arguments.output,
                               arguments.data.empty() ? "" : " --data " + arguments.data);
  if (arguments.tables.size() < thesis_h_tables().size()) {
    std::string tables;
    for (const std::string& table : arguments.tables) tables += (tables.empty() ? "" : ",") + table;
    report.command_line += " --tables " + tables;
  }
  report.grids = std::move(found.grids);
  report.pictures = std::move(found.pictures);
  report.warnings = outcome.warnings;
  if (!missing.empty()) report.warnings.insert(report.warnings.begin(), missing);
  report.times = outcome.times;
  write_file(arguments.output, html(report));
  outcome.lines.push_back("wrote " + arguments.output);
  return outcome;
}

}  // namespace

void add_report(CLI::App& app) {
  auto arguments = std::make_shared<ReportArguments>();
  arguments->tables = thesis_h_tables();
  CLI::App* command =
      add_command(app, "report", "Repeat the tables of a thesis with our figures beside its own.",
                  "batten report thesis-h -o thesis-h.html --data ../shared/data",
                  [arguments](Context& context) { return run_report(*arguments, context); });
  command->add_option("EXPERIMENT", arguments->experiment, "thesis-h: Huska, chapter 2")
      ->required()
      ->check(CLI::IsMember({"thesis-h"}));
  command->add_option("-o,--output", arguments->output, "HTML page to write, with pictures")
      ->check([](const std::string& path) {
        const std::string extension = file_extension(path);
        return extension == "html" || extension == "htm" ? std::string()
                                                         : concat("--output must name an .html file: ", path);
      });
  command->add_option("--data", arguments->data,
                      concat("Folder with the meshes, by their names; by default ", kDefaultData));
  command->add_option("--tables", arguments->tables, "Only these tables, joined by commas")
      ->delimiter(',')
      ->check(CLI::IsMember(thesis_h_tables()));
}

}  // namespace batten::cli
