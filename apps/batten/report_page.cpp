#include "report_page.hpp"

#include "command_group.hpp"

#include <string>
#include <utility>
#include <vector>

#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/report/report.hpp"

namespace batten::cli {

namespace {

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
  std::string line = "batten " + command_words(command);
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

}  // namespace

void write_report(const std::string& path, const CLI::App& command, const Outcome& outcome,
                  const Progress& progress) {
  Report report;
  report.title = "batten " + command_words(command);
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
    report.pictures = exhibit_pictures(outcome.exhibit, progress);
  }
  write_file(path, html(report));
}

}  // namespace batten::cli
