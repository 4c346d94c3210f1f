#include "batten/capture/terminal_keys.hpp"

#include <cstdlib>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

namespace batten::test {
namespace {

TEST(KeysOf, KnowsEndsOfLinesBothBackspacesAndEscapeSequences) {
  const std::vector<std::string> expected = {"+", "1", "enter", "backspace", "backspace", ".", "q"};
  EXPECT_EQ(keys_of("+1\n\x7f\b\x1b[A\x1b[3~\x1bOPx.q"), expected);
}

TEST(TerminalKeys, GivesSingleKeysAndLeavesTheTerminalAsItWas) {
  const int master = posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_GE(master, 0);
  ASSERT_EQ(grantpt(master), 0);
  ASSERT_EQ(unlockpt(master), 0);
  const std::string name = ptsname(master);
  // In a session of its own, whose terminal the pseudo-terminal is.
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    setsid();
    const int terminal = open(name.c_str(), O_RDWR);  // becomes the controlling terminal
    dup2(terminal, STDIN_FILENO);
    termios before{}, during{}, after{};
    tcgetattr(STDIN_FILENO, &before);
    bool right = false;
    {
      TerminalKeys keys;
      tcgetattr(STDIN_FILENO, &during);
      if (write(master, "7.", 2) != 2) _exit(9);
      std::vector<std::string> got;
      while (got.size() < 2)
        for (const std::string& key : keys.read()) got.push_back(key);
      right = got == std::vector<std::string>{"7", "."};
    }
    tcgetattr(STDIN_FILENO, &after);
    right = right && (during.c_lflag & (ICANON | ECHO)) == 0 && (during.c_lflag & ISIG) != 0 &&
            after.c_lflag == before.c_lflag && (before.c_lflag & ICANON) != 0;
    _exit(right ? 0 : 1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  close(master);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace batten::test
