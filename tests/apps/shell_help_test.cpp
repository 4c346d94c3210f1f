#include "apps/run_batten.hpp"

#include <cstdlib>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace batten::test {
namespace {

std::vector<std::string> found(const std::string& text, const std::string& pattern) {
  const std::regex expression(pattern);
  std::vector<std::string> all;
  for (std::sregex_iterator match(text.begin(), text.end(), expression), end; match != end; ++match)
    all.push_back((*match)[1]);
  return all;
}

/// What bash offers for the last of these words.
std::string offered(const std::string& words) {
  write_file("complete.bash",
             "source completion.bash\nCOMP_WORDS=(" + words +
                 ")\nCOMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n_batten\necho \"${COMPREPLY[*]}\"\n");
  const std::string command = "cd '" + scratch() + "' && bash complete.bash >offered.txt 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0);
  std::string text = read_file("offered.txt");
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

TEST(Completion, OffersCommandsOptionsAndWords) {
  const auto bash = run_batten("completion bash");
  ASSERT_EQ(bash.exit_code, 0) << bash.err;
  write_file("completion.bash", bash.out);
  EXPECT_EQ(offered("batten sur"), "surface");
  EXPECT_EQ(offered("batten surface --edge"), "--edge-length");
  EXPECT_EQ(offered("batten surface --method bi"), "biharmonic biharmonic-normals");
  EXPECT_EQ(offered("batten report thesis-h-"), "thesis-h-fires");
  EXPECT_EQ(offered("batten completion f"), "fish");
  write_file("hull.net", "");
  EXPECT_EQ(offered("batten surface hul"), "hull.net");
}

using Names = std::set<std::string>;

/// The options that a help shows, in lines such as "  -o,--output TEXT REQUIRED  Mesh to write" and
/// "  --no-magnetometer{false}  Leave it out".
Names options_in_help(const std::string& help) {
  Names names;
  for (const std::string& line : found(help, "\\n  (-[^ \\n{]*)"))
    for (const std::string& name : found(line, "(-[^,]+)")) names.insert(name);
  return names;
}

std::vector<std::string> subcommands_in_help(const std::string& help) {
  const std::size_t begin = help.find("Subcommands:");
  if (begin == std::string::npos) return {};
  return found(help.substr(begin), "\\n  ([a-z]+) ");
}

/// The words of every command that does work ("surface", "rig check") with the options that its help shows.
std::map<std::string, Names> commands_in_help() {
  std::map<std::string, Names> all;
  for (const std::string& name : subcommands_in_help(run_batten("--help").out)) {
    const std::string help = run_batten(name + " --help").out;
    const std::vector<std::string> inner = subcommands_in_help(help);
    if (inner.empty()) all[name] = options_in_help(help);
    for (const std::string& each : inner)
      all[name + ' ' + each] = options_in_help(run_batten(name + ' ' + each + " --help").out);
  }
  return all;
}

Names as_set(const std::vector<std::string>& names) {
  return {names.begin(), names.end()};
}

/// What stands between the first `begin` and the `end` behind it; nothing where there is no such place.
std::string between(const std::string& text, const std::string& begin, const std::string& end) {
  const std::size_t from = text.find(begin);
  if (from == std::string::npos) return {};
  return text.substr(from, text.find(end, from + begin.size()) - from);
}

/// The options that a page of the manual has for a command: of a group's page the part of this command.
Names options_in_page(const std::string& page, const std::string& words) {
  const bool in_group = words.find(' ') != std::string::npos;
  Names names;
  for (const std::string& line :
       found(in_group ? between(page, "\n.SH " + words + "\n", "\n.SH ") : page, "\\n\\.B (\\\\-[^\\n]*)"))
    for (const std::string& name : found(line, "((?:\\\\-)+[a-z]+(?:\\\\-[a-z]+)*)(?=,| |$)"))
      names.insert(std::regex_replace(name, std::regex("\\\\-"), "-"));
  return names;
}

// The help is what CLI11 prints of the options: the same names, no fewer and no more, stand in the
// completions and in the manual of every command.
TEST(ShellHelp, HasExactlyTheOptionsOfEveryHelp) {
  write_file("completion.bash", run_batten("completion bash").out);
  const std::string zsh = run_batten("completion zsh").out, fish = run_batten("completion fish").out,
                    manual = run_batten("manual").out;
  std::map<std::string, std::string> pages;
  const auto commands = commands_in_help();
  EXPECT_GE(commands.size(), 27U);
  for (const auto& [words, options] : commands) {
    SCOPED_TRACE(words);
    EXPECT_GE(options.size(), 2U);
    EXPECT_EQ(as_set(found(offered("batten " + words + " -"), "(-[^ ]+)")), options);

    const std::string of_command = between(zsh, "    '" + words + "')\n", ";;");
    EXPECT_EQ(as_set(found(of_command, "'(-[^\\[]+)\\[")), options);

    const std::string condition =
        std::regex_replace(words, std::regex(" "), "; and __fish_seen_subcommand_from ");
    Names in_fish;
    for (const std::string& line :
         found(fish, "'__fish_seen_subcommand_from " + condition + "'((?: -s [a-z]+| -l [a-z-]+)+)")) {
      for (const std::string& name : found(line, "-s ([a-z]+)")) in_fish.insert("-" + name);
      for (const std::string& name : found(line, "-l ([a-z-]+)")) in_fish.insert("--" + name);
    }
    EXPECT_EQ(in_fish, options);

    const std::string name = words.substr(0, words.find(' '));
    std::string& page = pages[name];
    if (page.empty()) page = run_batten("manual " + name).out;
    EXPECT_EQ(options_in_page(page, words), options);
    EXPECT_NE(manual.find(".BR batten\\-" + name + " (1)"), std::string::npos);
  }
}

// What man itself says of the pages: unknown macros and escapes, lines that cannot be broken.
TEST(Manual, IsReadByManWithoutAWarning) {
  if (std::system("man --version >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "man is not installed: tools/setup package";
  std::string pages;
  std::vector<std::string> names = subcommands_in_help(run_batten("--help").out);
  names.emplace_back();
  for (const std::string& name : names) {
    write_file("page" + name + ".1", run_batten("manual " + name).out);
    pages += " page" + name + ".1";
  }
  const std::string command = "cd '" + scratch() +
                              "' && LC_ALL=C.UTF-8 MANWIDTH=80 man --warnings -E UTF-8 -P cat -l" + pages +
                              " >shown.txt 2>said.txt";
  EXPECT_EQ(std::system(command.c_str()), 0);
  EXPECT_EQ(read_file("said.txt"), "");
  EXPECT_EQ(found(read_file("shown.txt"), "\\n(NAME)\\n").size(), names.size());
}

TEST(Manual, RefusesWhatIsNoCommand) {
  EXPECT_EQ(run_batten("manual nothing").exit_code, 2);
  EXPECT_EQ(run_batten("completion tcsh").exit_code, 2);
}

}  // namespace
}  // namespace batten::test
