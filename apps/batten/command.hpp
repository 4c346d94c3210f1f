#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/report/exhibit.hpp"

namespace batten::cli {

using Json = nlohmann::ordered_json;

/// What every command gives back: the one object printed by --json, or the lines printed without it.
struct Outcome {
  Json figures = Json::object();      ///< counts and figures, at the top level of the object
  StageTimes times;                   ///< becomes "seconds"
  std::vector<std::string> warnings;  ///< becomes "warnings"; printed to stderr without --json
  std::vector<std::string> lines;     ///< printed to stdout without --json
  Exhibit exhibit;                    ///< drawn by --report; may be empty
  std::string failure;      ///< a sentence: the result is printed all the same, and the exit code is 1
  std::string refusal;      ///< the same where the input is to blame; the exit code is 3
  bool is_printed = false;  ///< the work has said itself, while it ran, what there is to say
};

/// Adds what a request of the library did beside its result: its stage times and its warnings, in which an
/// option named in backquotes becomes its flag (`keep_edges` → --keep-edges).
void add_run(const StageTimes& times, const std::vector<std::string>& warnings, Outcome& outcome);

/// The surroundings of a command that runs.
struct Context {
  Progress progress;                 ///< draws a line on a terminal, silent elsewhere; Ctrl-C cancels
  bool json = false, quiet = false;  ///< for work that prints while it runs
};

using Work = std::function<Outcome(Context&)>;

/// Adds a subcommand. `options` are listed by CLI11 as usual; the values of all of them, given or default,
/// are repeated in the "options" of the JSON object. `--json`, `--quiet`, `--report` and
/// `--threads` are added here.
/// @param example one line, shown at the end of --help.
CLI::App* add_command(CLI::App& app, const std::string& name, const std::string& description,
                      const std::string& example, Work work);

/// Adds --columns, by which sensor logs of other programs are read.
void add_columns_option(CLI::App& command, std::string& columns);

/// What a result that is not sound means for a run: a failure that says that `output` was not written, or
/// where flaws are accepted a warning. Nothing without flaws.
/// @param what begins the sentence.
void report_flaws(const std::vector<std::string>& flaws, const std::string& what, const std::string& output,
                  bool accepted, Outcome& outcome);

/// Metres in "mm", "in" and the like. @throws InvalidInput naming the units there are.
double metres_per_unit(const std::string& unit);

/// A check of an option that runs while the command line is parsed: where `parse` throws InvalidInput, the
/// value is bad usage and its sentence the answer. `form` stands for the value in --help.
CLI::Validator parses(const std::string& form, std::function<void(const std::string&)> parse);

/// Runs the program. Exit codes: 0 ok, 1 the work failed, 2 bad usage, 3 bad input, 130 interrupted.
int run(int argc, char** argv);

// One function per command, each in its own source; registered in main.cpp.
void add_simulate(CLI::App& app);
void add_calibrate(CLI::App& app);
void add_orient(CLI::App& app);
void add_capture(CLI::App& app);
void add_replay(CLI::App& app);
void add_network(CLI::App& app);
void add_surface(CLI::App& app);
void add_track(CLI::App& app);
void add_pen(CLI::App& app);
void add_sketch(CLI::App& app);
void add_reconstruct(CLI::App& app);
void add_compare(CLI::App& app);
void add_check(CLI::App& app);
void add_convert(CLI::App& app);
void add_render(CLI::App& app);
void add_subdivide(CLI::App& app);
void add_info(CLI::App& app);
void add_fair(CLI::App& app);
void add_remesh(CLI::App& app);
void add_simplify(CLI::App& app);
void add_deform(CLI::App& app);
void add_repair(CLI::App& app);
void add_report(CLI::App& app);
void add_studio(CLI::App& app);

}  // namespace batten::cli
