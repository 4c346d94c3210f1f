#include "apps/run_batten.hpp"

#include <cstdlib>
#include <regex>
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
  EXPECT_EQ(offered("batten report the"), "thesis-h");
  EXPECT_EQ(offered("batten completion f"), "fish");
  write_file("hull.net", "");
  EXPECT_EQ(offered("batten surface hul"), "hull.net");
}

// Every option of every command stands in each of them.
TEST(Completion, KnowsEveryOption) {
  const std::string commands = run_batten("--help").out;
  const std::string bash = run_batten("completion bash").out, zsh = run_batten("completion zsh").out,
                    fish = run_batten("completion fish").out;
  const std::vector<std::string> names =
      found(commands.substr(commands.find("Subcommands:")), "\\n  ([a-z]+) ");
  EXPECT_GE(names.size(), 18U);
  for (const std::string& name : names) {
    const std::string page = run_batten("manual " + name).out;
    EXPECT_NE(page.find(".SH NAME"), std::string::npos) << name;
    EXPECT_NE(fish.find(" -a " + name + " "), std::string::npos) << name;
    for (const std::string& option : found(run_batten(name + " --help").out, "--([a-z][a-z-]*)[ ,]")) {
      if (option == "help") continue;
      EXPECT_NE(bash.find("--" + option), std::string::npos) << name << ' ' << option;
      EXPECT_NE(zsh.find("--" + option + "["), std::string::npos) << name << ' ' << option;
      EXPECT_NE(fish.find(" -l " + option + " "), std::string::npos) << name << ' ' << option;
    }
  }
  EXPECT_NE(run_batten("manual").out.find(".BR batten\\-surface (1)"), std::string::npos);
}

TEST(Manual, RefusesWhatIsNoCommand) {
  EXPECT_EQ(run_batten("manual nothing").exit_code, 2);
  EXPECT_EQ(run_batten("completion tcsh").exit_code, 2);
}

}  // namespace
}  // namespace batten::test
