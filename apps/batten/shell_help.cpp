#include "shell_help.hpp"

#include "command_group.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include "batten/core/text.hpp"

namespace batten::cli {

namespace {

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

/// A command that does work, with its words: those of groups stand in their place.
struct Leaf {
  std::string words;
  const CLI::App* command;
};
std::vector<Leaf> leaves_of(const CLI::App& app) {
  std::vector<Leaf> leaves;
  for (const CLI::App* command : commands_of(app)) {
    const std::vector<const CLI::App*> inner = commands_of(*command);
    if (inner.empty()) leaves.push_back({command_words(*command), command});
    for (const CLI::App* each : inner) leaves.push_back({command_words(*each), each});
  }
  return leaves;
}

/// The options of a command that its help shows, but those without a name, which are its arguments.
std::vector<const CLI::Option*> options_of(const CLI::App& command) {
  return command.get_options(
      [](const CLI::Option* option) { return option->nonpositional() && !option->get_group().empty(); });
}
std::vector<const CLI::Option*> arguments_of(const CLI::App& command) {
  return command.get_options([](const CLI::Option* option) { return option->get_positional(); });
}

bool takes_value(const CLI::Option& option) {
  return option.get_expected_max() != 0;
}

/// "-o" and "--output" of an option.
std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

/// The words that an option or argument takes, where it takes no others.
std::vector<std::string> words_of(const CLI::Option& option) {
  // CLI11 shows a set of words as TEXT:{one,two}.
  const std::string form = option.get_type_name();
  const std::size_t begin = form.find('{'), end = form.find('}');
  std::vector<std::string> words;
  if (begin == std::string::npos || end == std::string::npos || end < begin) return words;
  for (std::size_t at = begin + 1; at < end;) {
    const std::size_t next = std::min(form.find(',', at), end);
    words.push_back(form.substr(at, next - at));
    at = next + 1;
  }
  return words;
}

std::string joined(const std::vector<std::string>& words, std::string_view between) {
  std::string text;
  for (const std::string& word : words) text += concat(text.empty() ? std::string_view() : between, word);
  return text;
}

/// The text with a backslash before each of `special`.
std::string escaped(std::string_view text, std::string_view special) {
  std::string result;
  for (const char c : text) {
    if (special.find(c) != std::string_view::npos) result += '\\';
    result += c;
  }
  return result;
}

/// Between single quotes of a shell.
std::string single_quoted(std::string_view text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

std::string bash_completion(const CLI::App& app) {
  std::vector<std::string> commands;
  std::string values, options, groups;
  for (const CLI::App* command : commands_of(app)) {
    commands.push_back(command->get_name());
    std::vector<std::string> inner;
    for (const CLI::App* each : commands_of(*command)) inner.push_back(each->get_name());
    if (!inner.empty())
      groups += concat(
          "    ", command->get_name(),
          ")\n      if ((COMP_CWORD == 2)); then\n        COMPREPLY=($(compgen -W '", joined(inner, " "),
          "' -- \"$word\"))\n        return\n      fi\n      command=\"$command ${COMP_WORDS[2]}\" ;;\n");
  }
  for (const Leaf& leaf : leaves_of(app)) {
    std::vector<std::string> names;
    for (const CLI::Option* option : options_of(*leaf.command)) {
      const std::vector<std::string> words = words_of(*option);
      for (const std::string& name : names_of(*option)) {
        names.push_back(name);
        if (!words.empty())
          values += concat("    '", leaf.words, " ", name, "') words='", joined(words, " "), "' ;;\n");
      }
    }
    options += concat("      '", leaf.words, "') words='", joined(names, " "), "' ;;\n");
    std::string first;
    for (const CLI::Option* argument : arguments_of(*leaf.command))
      if (first.empty()) first = joined(words_of(*argument), " ");
    if (!first.empty())
      values += concat("    '", leaf.words, " ", leaf.command->get_name(), "') [[ $word == -* ]] || words='",
                       first, "' ;;\n");
  }
  return concat(
      "# Completion of batten for bash: source <(batten completion bash)\n"
      "_batten() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} command=${COMP_WORDS[1]} "
      "words=\n"
      "  COMPREPLY=()\n"
      "  if ((COMP_CWORD == 1)); then\n"
      "    COMPREPLY=($(compgen -W '",
      joined(commands, " "),
      " --help --version' -- \"$word\"))\n"
      "    return\n"
      "  fi\n"
      "  case $command in\n",
      groups,
      "  esac\n"
      "  case \"$command $previous\" in\n",
      values,
      "  esac\n"
      "  if [[ -z $words && $word == -* ]]; then\n"
      "    case $command in\n",
      options,
      "    esac\n"
      "  fi\n"
      "  if [[ -n $words ]]; then\n"
      "    COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
      "  else\n"
      "    COMPREPLY=($(compgen -f -- \"$word\"))\n"
      "    compopt -o filenames 2>/dev/null\n"
      "  fi\n"
      "}\n"
      "complete -F _batten batten\n");
}

std::string zsh_completion(const CLI::App& app) {
  std::string commands, cases, groups;
  for (const CLI::App* command : commands_of(app)) {
    commands += concat(
        "    ", single_quoted(concat(command->get_name(), ":", escaped(command->get_description(), ":"))),
        "\n");
    std::vector<std::string> inner;
    for (const CLI::App* each : commands_of(*command)) inner.push_back(each->get_name());
    if (!inner.empty())
      groups += concat("    ", command->get_name(), ")\n      if ((CURRENT == 2)); then\n        compadd ",
                       joined(inner, " "),
                       "\n        return\n      fi\n      command=\"$command $words[2]\"\n      shift words\n"
                       "      ((CURRENT--))\n      ;;\n");
  }
  for (const Leaf& leaf : leaves_of(app)) {
    const CLI::App* command = leaf.command;
    cases += concat("    '", leaf.words, "')\n      _arguments");
    for (const CLI::Option* option : options_of(*command)) {
      const std::vector<std::string> words = words_of(*option);
      for (const std::string& name : names_of(*option)) {
        std::string spec = concat(name, "[", escaped(option->get_description(), "[]:\\"), "]");
        if (takes_value(*option))
          spec += words.empty() ? std::string(":value:_files") : concat(":value:(", joined(words, " "), ")");
        cases += concat(" \\\n        ", single_quoted(spec));
      }
    }
    std::string rest = "*:file:_files";
    for (const CLI::Option* argument : arguments_of(*command))
      if (const auto words = words_of(*argument); !words.empty())
        rest = concat("*:value:(", joined(words, " "), ")");
    cases += concat(" \\\n        ", single_quoted(rest), "\n      ;;\n");
  }
  return concat(
      "#compdef batten\n# Completion of batten for zsh: source <(batten completion zsh)\n"
      "_batten() {\n  local -a commands\n  commands=(\n",
      commands,
      "  )\n  if ((CURRENT == 2)); then\n    _describe command commands\n    return\n  fi\n"
      "  local command=$words[2]\n  shift words\n  ((CURRENT--))\n  case $command in\n",
      groups, "  esac\n  case $command in\n", cases,
      "  esac\n}\n"
      "if [[ $funcstack[1] == _batten ]]; then\n  _batten \"$@\"\nelse\n  compdef _batten batten\nfi\n");
}

std::string fish_completion(const CLI::App& app) {
  std::string text = "# Completion of batten for fish: batten completion fish | source\n";
  for (const CLI::App* command : commands_of(app)) {
    text += concat("complete -c batten -n __fish_use_subcommand -f -a ", command->get_name(), " -d ",
                   single_quoted(command->get_description()), "\n");
    for (const CLI::App* each : commands_of(*command))
      text += concat("complete -c batten -n '__fish_seen_subcommand_from ", command->get_name(), "' -f -a ",
                     each->get_name(), " -d ", single_quoted(each->get_description()), "\n");
  }
  for (const auto& [typed, command] : leaves_of(app)) {
    const std::size_t blank = typed.find(' ');
    std::string condition = concat("'__fish_seen_subcommand_from ", typed.substr(0, blank));
    if (blank != std::string::npos)
      condition += concat("; and __fish_seen_subcommand_from ", typed.substr(blank + 1));
    condition += "'";
    for (const CLI::Option* option : options_of(*command)) {
      text += concat("complete -c batten -n ", condition);
      for (const std::string& name : option->get_snames()) text += concat(" -s ", name);
      for (const std::string& name : option->get_lnames()) text += concat(" -l ", name);
      text += concat(" -d ", single_quoted(option->get_description()));
      const std::vector<std::string> words = words_of(*option);
      if (takes_value(*option)) text += " -r";
      if (!words.empty()) text += concat(" -f -a ", single_quoted(joined(words, " ")));
      text += '\n';
    }
    for (const CLI::Option* argument : arguments_of(*command))
      if (const auto words = words_of(*argument); !words.empty())
        text +=
            concat("complete -c batten -n ", condition, " -f -a ", single_quoted(joined(words, " ")), "\n");
  }
  return text;
}

/// Text for troff: hyphens stay hyphens, no line begins with a control character, and a list without blanks
/// may be broken behind its commas.
std::string troff(std::string_view text) {
  std::string result;
  char before = '\n';
  for (const char c : text) {
    if (before == '\n' && (c == '.' || c == '\'')) result += "\\&";
    if (before == ',' && c != ' ') result += "\\:";
    if (c == '\\')
      result += "\\e";
    else if (c == '-')
      result += "\\-";
    else
      result += c;
    before = c;
  }
  return result;
}

std::string heading(const std::string& name, const std::string& description) {
  return concat(".TH ", escaped(name, "\""),
                " 1 \"\" \"batten " BATTEN_VERSION "\" \"Batten\"\n.ad l\n.SH NAME\n", troff(name), " \\- ",
                troff(description), "\n");
}

void add_options(const std::vector<const CLI::Option*>& options, std::string& page) {
  for (const CLI::Option* option : options) {
    std::vector<std::string> names = names_of(*option);
    if (names.empty()) names.push_back(option->get_single_name());
    page += concat(".TP\n.B ", troff(joined(names, ", ")));
    if (option->nonpositional() && takes_value(*option)) {
      std::string form = option->get_type_name();
      if (const std::vector<std::string> words = words_of(*option); !words.empty()) form = joined(words, "|");
      page += concat(" \\fI", troff(form), "\\fR");
    }
    page += concat("\n", troff(option->get_description()));
    if (!option->get_default_str().empty()) page += concat(" [", troff(option->get_default_str()), "]");
    if (option->get_required()) page += " (required)";
    page += '\n';
  }
}

constexpr const char* kExitStatus =
    ".SH EXIT STATUS\n.TP\n0\ndone\n.TP\n1\nthe work failed, or its result is not sound\n.TP\n2\nthe command "
    "line is "
    "wrong\n.TP\n3\nthe input is wrong\n.TP\n130\ninterrupted\n";

/// To be sourced by the shell: "bash", "zsh" or "fish".
std::string completion_for(const CLI::App& app, const std::string& shell) {
  return shell == "bash" ? bash_completion(app) : shell == "zsh" ? zsh_completion(app) : fish_completion(app);
}

/// A page in troff: of the program, or of one of its commands. @param command null: the program.
std::string manual_page(const CLI::App& app, const CLI::App* command) {
  if (command == nullptr) {
    std::string page = heading("batten", app.get_description());
    page += ".SH SYNOPSIS\n.B batten\n\\fICOMMAND\\fR [\\fIOPTION\\fR]...\n.SH COMMANDS\n";
    std::string others;
    for (const CLI::App* each : commands_of(app)) {
      page += concat(".TP\n.B ", each->get_name(), "\n", troff(each->get_description()), "\n");
      others += concat(others.empty() ? "" : ",\n", ".BR batten\\-", each->get_name(), " (1)");
    }
    return concat(
        page, kExitStatus,
        ".SH ENVIRONMENT\n.TP\n.B BATTEN_THREADS\nMost threads to work on, where \\-\\-threads says "
        "nothing\n.SH SEE ALSO\n",
        others, "\n");
  }
  std::string page = heading("batten-" + command->get_name(), command->get_description());
  std::vector<Leaf> parts{{command->get_name(), command}};
  if (!commands_of(*command).empty()) parts = leaves_of(app);
  page += ".SH SYNOPSIS\n";
  for (const Leaf& part : parts) {
    if (part.command != command && part.command->get_parent() != command) continue;
    page += concat(".B batten ", part.words, "\n");
    for (const CLI::Option* argument : arguments_of(*part.command))
      page += concat("\\fI", troff(argument->get_single_name()), "\\fR\n");
    page += "[\\fIOPTION\\fR]...\n.br\n";
  }
  for (const Leaf& part : parts) {
    if (part.command != command && part.command->get_parent() != command) continue;
    if (part.command != command)
      page += concat(".SH ", escaped(part.words, "\""), "\n", troff(part.command->get_description()), "\n");
    if (!arguments_of(*part.command).empty()) {
      page += part.command == command ? ".SH ARGUMENTS\n" : ".SS Arguments\n";
      add_options(arguments_of(*part.command), page);
    }
    page += part.command == command ? ".SH OPTIONS\n" : ".SS Options\n";
    add_options(options_of(*part.command), page);
    page += concat(part.command == command ? ".SH EXAMPLE\n.nf\n" : ".SS Example\n.nf\n",
                   troff(part.command->get_footer()), "\n.fi\n");
  }
  page += concat(kExitStatus, ".SH SEE ALSO\n.BR batten (1)\n");
  return page;
}

}  // namespace

ShellHelp::ShellHelp(CLI::App& app)
    : completion_(
          app.add_subcommand("completion", "Print the completion of commands and options for a shell.")),
      manual_(app.add_subcommand("manual", "Print a page of the manual, for man.")) {
  completion_->footer("Example:\n  source <(batten completion bash)");
  completion_->add_option("SHELL", shell_, "bash, zsh or fish")
      ->required()
      ->check(CLI::IsMember({"bash", "zsh", "fish"}));
  manual_->footer("Example:\n  batten manual surface | man -l -");
  manual_->add_option("COMMAND", page_, "The command that it is about; the program when left out");
}

std::optional<std::string> ShellHelp::text(const CLI::App& app) const {
  if (completion_->parsed()) return completion_for(app, shell_);
  if (!manual_->parsed()) return std::nullopt;
  if (page_.empty()) return manual_page(app, nullptr);
  for (const CLI::App* command : commands_of(app))
    if (command->get_name() == page_) return manual_page(app, command);
  throw CLI::ValidationError(concat("there is no command '", page_, "'"));
}

}  // namespace batten::cli
