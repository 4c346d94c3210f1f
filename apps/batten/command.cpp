#include "command.hpp"

#include "command_group.hpp"
#include "commands/words.hpp"
#include "report_page.hpp"
#include "shell_help.hpp"
#include "suggestions.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <new>

#include <unistd.h>

#include "batten/core/error.hpp"
#include "batten/core/parallel.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/log_columns.hpp"
#include "batten/io/standard_streams.hpp"

namespace batten::cli {

namespace {

enum ExitCode { kOk = 0, kWorkFailed = 1, kBadUsage = 2, kBadInput = 3, kInterrupted = 130 };

std::atomic<bool> interrupted{false};

/// The work of the subcommand that was chosen, run after parsing so that usage errors come first.
struct Chosen {
  CLI::App* command = nullptr;
  Work work;
  bool json = false;
  bool quiet = false;
  std::string report;           ///< path of the HTML report, or empty
  std::string threads = "all";  ///< as given, or "all"
};
Chosen chosen;

/// The number of threads; 0 for "all". @param where the option or variable to name in the error.
/// @throws InvalidInput on anything else.
int parse_threads(const std::string& text, std::string_view where) {
  constexpr int kMost = 1024;  // more than any processor has today; a larger number is a slip
  long value = 0;
  if (text == "all") return 0;
  if (!parse_integer(text, value) || value < 1 || value > kMost)
    throw InvalidInput(
        concat(where, " must be all or a whole number from 1 to ", kMost, ", got '", text, "'"));
  return static_cast<int>(value);
}

/// --threads, else BATTEN_THREADS, else all. @throws InvalidInput when the variable holds no number of
/// threads.
void choose_threads() {
  const char* variable = std::getenv("BATTEN_THREADS");
  if (chosen.command->get_option("--threads")->count() == 0 && variable != nullptr && *variable != '\0')
    set_thread_count(parse_threads(variable, "BATTEN_THREADS"));
  else
    set_thread_count(parse_threads(chosen.threads, "--threads"));
}

Progress terminal_progress() {
  const bool visible = isatty(STDERR_FILENO) != 0 && !chosen.quiet;
  auto last = std::make_shared<std::chrono::steady_clock::time_point>();
  return Progress([visible, last](std::string_view stage, double fraction) {
    const auto now = std::chrono::steady_clock::now();
    if (visible && now - *last > std::chrono::milliseconds(100)) {
      *last = now;
      std::fprintf(stderr, "\r\033[K%.*s %3.0f %%", static_cast<int>(stage.size()), stage.data(),
                   100 * fraction);
    }
    return !interrupted.load();
  });
}

void clear_progress_line() {
  if (isatty(STDERR_FILENO) != 0) std::fprintf(stderr, "\r\033[K");
}

/// The value of an option as JSON: numbers and booleans as such, everything else as text.
Json option_value(const CLI::Option& option) {
  const auto typed = [](const std::string& text) -> Json {
    Json parsed = Json::parse(text, nullptr, false);
    if (parsed.is_number() || parsed.is_boolean()) return parsed;
    return text;
  };
  if (option.get_expected_max() == 0) return option.count() > 0;
  if (option.count() == 0)
    return option.get_default_str().empty() ? Json(nullptr) : typed(option.get_default_str());
  if (option.results().size() == 1) return typed(option.results().front());
  Json list = Json::array();
  for (const std::string& text : option.results()) list.push_back(typed(text));
  return list;
}

Json option_values(const CLI::App& command) {
  Json values = Json::object();
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_single_name();
    if (name != "help" && name != "json" && name != "quiet") values[name] = option_value(*option);
  }
  values["threads"] = thread_count();  // in use, wherever the number comes from
  return values;
}

/// Where figures and sentences are printed: beside standard output where a result went there.
std::ostream& printed() {
  return standard_output_taken() ? std::cerr : std::cout;
}

void print(const Outcome& outcome) {
  std::ostream& out = printed();
  if (!chosen.json) {
    if (chosen.quiet) return;
    for (const std::string& line : outcome.lines) out << line << '\n';
    for (const std::string& warning : outcome.warnings) std::cerr << "warning: " << warning << '\n';
    return;
  }
  Json object = Json::object();
  object["command"] = command_words(*chosen.command);
  for (const auto& [key, value] : outcome.figures.items()) object[key] = value;
  object["options"] = option_values(*chosen.command);
  Json seconds = Json::object();
  for (const auto& [stage, time] : outcome.times.stages()) seconds[stage] = time;
  seconds["total"] = outcome.times.total();
  object["seconds"] = seconds;
  object["warnings"] = outcome.warnings;
  out << object.dump(2) << '\n';
}

const char* word_of(ExitCode code) {
  switch (code) {
    case kBadUsage:
      return "usage";
    case kBadInput:
      return "input";
    case kInterrupted:
      return "interrupted";
    default:
      return "failed";
  }
}

/// Says on standard error what went wrong; with --json also as the one object on standard output, unless
/// that already holds what was made.
/// @param file what the sentence begins with, or empty.
int fail(ExitCode code, std::string_view sentence, bool is_printed = false, const std::string& file = {},
         long line = 0) {
  clear_progress_line();
  std::cerr << "batten: " << sentence << '\n';
  if (!chosen.json || is_printed) return code;
  // By convention a sentence says what is wrong, and behind the last semicolon what helps.
  const std::size_t remedy = sentence.rfind("; ");
  Json error = {{"code", word_of(code)}, {"message", sentence}};
  error["file"] = file.empty() ? Json(nullptr) : Json(file);
  error["line"] = line > 0 ? Json(line) : Json(nullptr);
  error["remedy"] = remedy == std::string_view::npos ? Json(nullptr) : Json(sentence.substr(remedy + 2));
  std::ostream& out = printed();
  out << Json{{"error", error}}.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
  out.flush();
  return code;
}

/// What asks less of the memory, by the options that the command has.
std::string memory_remedy(const CLI::App& command) {
  static const std::pair<const char*, const char*> kRemedies[] = {
      {"--edge-length", "try a larger --edge-length"},
      {"--edge", "try a larger --edge"},
      {"--step", "try a larger --step"},
      {"--levels", "try fewer --levels"},
      {"--size", "try a smaller --size"},
      {"--samples", "try fewer --samples"},
      {"--resample", "try a larger --resample"}};
  for (const auto& [option, remedy] : kRemedies)
    if (command.get_option_no_throw(option) != nullptr) return remedy;
  return "try a smaller input, as batten simplify makes it";
}

int run_chosen() {
  Context context;
  context.progress = terminal_progress();
  context.json = chosen.json;
  context.quiet = chosen.quiet;
  try {
    const Outcome outcome = chosen.work(context);
    if (!chosen.report.empty()) write_report(chosen.report, *chosen.command, outcome, context.progress);
    clear_progress_line();
    if (!outcome.is_printed) print(outcome);
    std::cout.flush();
    if (!std::cout) return fail(kBadInput, "standard output cannot be written", true);
    if (!outcome.refusal.empty()) return fail(kBadInput, outcome.refusal, true);
    return outcome.failure.empty() ? kOk : fail(kWorkFailed, outcome.failure, true);
  } catch (const CLI::Error& error) {
    return fail(kBadUsage, error.what());
  } catch (const commands::UsageError& error) {
    return fail(kBadUsage, error.what());
  } catch (const UnknownExtension& error) {
    return fail(kBadUsage, error.what(), false, error.path());
  } catch (const FileError& error) {
    return fail(kBadInput, error.what(), false, error.path(), error.line());
  } catch (const InvalidInput& error) {
    return fail(kBadInput, error.what());
  } catch (const Cancelled& error) {
    fail(kInterrupted, error.what());
    std::fflush(nullptr);
    std::_Exit(kInterrupted);  // at once: a factorisation that cannot be interrupted may still be going on
  } catch (const Error& error) {
    return fail(kWorkFailed, error.what());
  } catch (const std::bad_alloc&) {
    return fail(kWorkFailed, concat("not enough memory for this; ", memory_remedy(*chosen.command)));
  } catch (const std::exception& error) {
    return fail(kWorkFailed, std::string("unexpected failure, please report it: ") + error.what());
  }
}

}  // namespace

CLI::App* add_command(CLI::App& app, const std::string& name, const std::string& description,
                      const std::string& example, Work work) {
  CLI::App* command = app.add_subcommand(name, description);
  command->footer("Example:\n  " + example);
  command->add_flag("--json", chosen.json, "Print exactly one JSON object to standard output");
  command->add_flag("--quiet", chosen.quiet, "Print nothing but errors");
  command->add_option("--report", chosen.report,
                      "Write an HTML report with pictures, figures, stage times and options");
  command->option_defaults()->always_capture_default();
  command
      ->add_option("--threads", chosen.threads,
                   "Most threads to work on; else BATTEN_THREADS, else all processors that may be used")
      ->check(parses("N", [](const std::string& text) { parse_threads(text, "--threads"); }));
  command->callback([command, work = std::move(work)] {
    chosen.command = command;
    chosen.work = work;
  });
  return command;
}

void add_run(const StageTimes& times, const std::vector<std::string>& warnings, Outcome& outcome) {
  outcome.times.add(times);
  for (const std::string& warning : warnings) {
    std::string shown;
    bool in_option = false;
    for (const char c : warning) {
      if (c == '`') {
        in_option = !in_option;
        if (in_option) shown += "--";
      } else {
        shown += in_option && c == '_' ? '-' : c;
      }
    }
    outcome.warnings.push_back(shown);
  }
}

void add_columns_option(CLI::App& command, std::string& columns) {
  command
      .add_option("--columns", columns,
                  "Sensor logs of other programs: auto, or what holds what, as "
                  "time=t_ms:ms,acc=ax:ay:az:g,mag=mx:my:mz:uT,gyr=gx:gy:gz:deg/"
                  "s,distance=ticks:0.026mm,curve=c,node=n")
      ->check(parses("auto|COLUMNS", [](const std::string& text) {
        if (text != "auto") parse_log_columns(text);
      }));
}

void report_flaws(const std::vector<std::string>& flaws, const std::string& what, const std::string& output,
                  bool accepted, Outcome& outcome) {
  if (flaws.empty()) return;
  std::string all;
  for (const std::string& flaw : flaws) all += (all.empty() ? "" : "; ") + flaw;
  if (accepted)
    outcome.warnings.push_back("accepted: " + all);
  else
    outcome.failure =
        concat(what, ": ", all, "; ", output, " was not written, --accept-flaws writes it all the same");
}

double metres_per_unit(const std::string& unit) {
  const Length one = parse_length("1" + unit);
  if (one.kind != Length::Kind::Metres)
    throw InvalidInput(concat("'", unit, "' is no unit of length; use m, cm, mm, um, km, in or ft"));
  return one.value;
}

CLI::Validator parses(const std::string& form, std::function<void(const std::string&)> parse) {
  return {[parse = std::move(parse)](std::string& text) {
            try {
              parse(text);
            } catch (const InvalidInput& error) {
              return std::string(error.what());
            }
            return std::string();
          },
          form};
}

namespace {

/// What a mistyped command or option was most likely meant to be, as a sentence, or nothing.
/// @param words of the commands before `arguments`.
std::string suggestion(const CLI::App& app, const std::vector<std::string>& arguments,
                       const std::string& words = "batten") {
  if (arguments.empty()) return {};
  std::vector<std::string> names;
  const CLI::App* command = nullptr;
  for (const CLI::App* each : app.get_subcommands({})) {
    names.push_back(each->get_name());
    if (each->get_name() == arguments[0]) command = each;
  }
  if (command == nullptr) {
    if (arguments[0].rfind('-', 0) == 0) return {};
    const std::string nearest = nearest_name(arguments[0], names);
    return concat("there is no command '", arguments[0], "'; ",
                  nearest.empty() ? concat("run ", words, " --help for all of them")
                                  : concat("did you mean ", nearest, "?"));
  }
  if (!command->get_subcommands({}).empty())
    return suggestion(*command, {arguments.begin() + 1, arguments.end()}, concat(words, " ", arguments[0]));
  std::vector<std::string> options;
  for (const CLI::Option* option : command->get_options())
    for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
  for (const std::string& argument : arguments) {
    const std::string given = argument.substr(0, argument.find('='));
    if (given.rfind("--", 0) != 0 || given.size() < 4) continue;
    if (std::find(options.begin(), options.end(), given) != options.end()) continue;
    const std::string nearest = nearest_name(given, options);
    return concat(words, " ", arguments[0], " has no option ", given, "; ",
                  nearest.empty() ? concat("run ", words, " ", arguments[0], " --help for all of them")
                                  : concat("did you mean ", nearest, "?"));
  }
  return {};
}

}  // namespace

int run(int argc, char** argv) {
  std::signal(SIGINT, [](int) { interrupted = true; });
  CLI::App app("Batten turns curves traced on an object into a fair surface.", "batten");
  app.require_subcommand(1);
  app.set_version_flag("--version", "batten " BATTEN_VERSION);
  add_simulate(app);
  add_calibrate(app);
  add_orient(app);
  add_capture(app);
  add_replay(app);
  add_network(app);
  add_surface(app);
  add_track(app);
  add_pen(app);
  add_sketch(app);
  add_reconstruct(app);
  add_subdivide(app);
  add_compare(app);
  add_check(app);
  add_convert(app);
  add_render(app);
  add_info(app);
  add_repair(app);
  add_fair(app);
  add_remesh(app);
  add_simplify(app);
  add_deform(app);
  add_report(app);
  add_rig(app);
  add_studio(app);
  const ShellHelp help(app);
  try {
    app.parse(argc, argv);
    if (const auto text = help.text(app)) {
      std::cout << *text;
      return kOk;
    }
  } catch (const CLI::Success& request) {  // --help, --version
    return app.exit(request);
  } catch (const CLI::ParseError& error) {
    const std::vector<std::string> arguments(argv + 1, argv + argc);
    // Not parsed: the flag is looked for by hand.
    chosen.json = std::find(arguments.begin(), arguments.end(), "--json") != arguments.end();
    if (const std::string sentence = suggestion(app, arguments); !sentence.empty())
      return fail(kBadUsage, sentence);
    return fail(kBadUsage, concat(error.what(), "; run with --help for more information"));
  } catch (const InvalidInput& error) {  // a length or an angle that does not parse
    return fail(kBadUsage, error.what());
  }
  try {
    choose_threads();
  } catch (const InvalidInput& error) {
    return fail(kBadUsage, error.what());
  }
  return run_chosen();
}

}  // namespace batten::cli
