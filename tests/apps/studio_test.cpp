#include "apps/run_batten.hpp"

#include <csignal>
#include <string>

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

namespace batten::test {
namespace {

/// The first line that `batten studio` prints; its standard error goes to the file studio.err.
class StudioProgram {
 public:
  explicit StudioProgram(const std::string& option) {
    int ends[2] = {-1, -1};
    EXPECT_EQ(::pipe(ends), 0);
    const std::string folder = scratch(),
                      errors = scratch_file("studio.err");  // of this process, not of the child
    pid_ = ::fork();
    if (pid_ == 0) {
      ::dup2(ends[1], 1);
      ::dup2(::open(errors.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), 2);
      ::execl(BATTEN_PROGRAM, BATTEN_PROGRAM, "studio", folder.c_str(), "--port", "0", "--no-browser",
              option.c_str(), nullptr);
      ::_exit(127);
    }
    ::close(ends[1]);
    for (char c = 0; ::read(ends[0], &c, 1) == 1 && c != '\n';) line += c;
    output_ = ends[0];
  }
  /// Sends a signal; the exit code.
  int end(int signal) {
    ::kill(pid_, signal);
    int status = 0;
    ::waitpid(pid_, &status, 0);
    for (char c = 0; ::read(output_, &c, 1) == 1;) rest += c;
    ::close(output_);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

  std::string line, rest;  ///< of its standard output

 private:
  pid_t pid_ = 0;
  int output_ = -1;
};

std::string asked(int port, const std::string& request) {
  const int wire = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string answer;
  if (::connect(wire, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0 &&
      ::send(wire, request.data(), request.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(request.size())) {
    char buffer[4096];
    for (ssize_t n = 0; (n = ::recv(wire, buffer, sizeof buffer, 0)) > 0;)
      answer.append(buffer, static_cast<std::size_t>(n));
  }
  ::close(wire);
  return answer;
}

TEST(Studio, PrintsItsAddressServesAndEndsWithASignal) {
  for (const int signal : {SIGTERM, SIGINT}) {
    StudioProgram program("--json");
    const auto json = nlohmann::json::parse(program.line, nullptr, false);
    ASSERT_TRUE(json.is_object()) << program.line;
    const int port = json["port"];
    const std::string host = "127.0.0.1:" + std::to_string(port);
    EXPECT_EQ(json["url"].get<std::string>().rfind("http://" + host + "/#", 0), 0U) << json;
    const std::string answer =
        asked(port, "GET / HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n\r\n");
    EXPECT_EQ(answer.rfind("HTTP/1.1 ", 0), 0U) << answer;
    EXPECT_NE(answer.find("Content-Security-Policy: default-src 'self'"), std::string::npos);
    EXPECT_EQ(asked(port, "GET / HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n").substr(0, 12),
              "HTTP/1.1 421");
    EXPECT_EQ(program.end(signal), 0);
    EXPECT_EQ(program.rest, "") << "one line, whatever happens";
    EXPECT_NE(read_file("studio.err").find("refused: 421 GET /"), std::string::npos);
  }
}

TEST(Studio, PrintsForPeopleWithoutJson) {
  StudioProgram program("--threads=1");
  EXPECT_EQ(program.line.rfind("studio: http://127.0.0.1:", 0), 0U) << program.line;
  EXPECT_EQ(program.end(SIGTERM), 0);
}

TEST(Studio, WrongLinesAreRefused) {
  EXPECT_EQ(run_batten("studio --port 65536 --no-browser").exit_code, 2);
  EXPECT_EQ(run_batten("studio --port x --no-browser").exit_code, 2);
  EXPECT_EQ(run_batten("studio no/such/folder --no-browser").exit_code, 3);
  EXPECT_EQ(run_batten("studio --page no/such/folder --no-browser").exit_code, 3);
  EXPECT_EQ(run_batten("studio --report x.html").exit_code, 2);
  EXPECT_EQ(run_batten("studio --help").out.find("--page"), std::string::npos);
}

}  // namespace
}  // namespace batten::test
