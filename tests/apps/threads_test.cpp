#include "apps/run_batten.hpp"
#include "sanitizers.hpp"

#include <cmath>
#include <cstdlib>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::test {
namespace {

using Json = nlohmann::json;

/// Sets BATTEN_THREADS for one run.
class Variable {
 public:
  explicit Variable(const char* value) { setenv("BATTEN_THREADS", value, 1); }
  ~Variable() { unsetenv("BATTEN_THREADS"); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;
};

/// A wavy torus of n × n vertices with noise that looks random and is not.
std::string wavy_torus(int n) {
  std::ostringstream out;
  const auto angle = [n](int i) { return 2 * 3.14159265358979 * i / n; };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double noise = 0.003 * std::sin(12.9898 * i * i + 78.233 * j * (j + 3));
      const double tube = 0.4 + 0.05 * std::cos(5 * angle(i)) * std::sin(3 * angle(j)) + noise;
      const double r = 1 + tube * std::cos(angle(j));
      out << "v " << r * std::cos(angle(i)) << ' ' << r * std::sin(angle(i)) << ' '
          << tube * std::sin(angle(j)) << '\n';
    }
  const auto number = [n](int i, int j) { return (i % n) * n + j % n + 1; };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      out << "f " << number(i, j) << ' ' << number(i + 1, j) << ' ' << number(i + 1, j + 1) << '\n';
      out << "f " << number(i, j) << ' ' << number(i + 1, j + 1) << ' ' << number(i, j + 1) << '\n';
    }
  return out.str();
}

Json::value_type threads_of(const std::string& options) {
  const test::Run run = run_batten("info torus.obj --json " + options);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return Json::parse(run.out)["options"]["threads"];
}

TEST(Threads, AreThoseOfTheOptionElseOfTheVariableElseAll) {
  write_file("torus.obj", wavy_torus(8));
  unsetenv("BATTEN_THREADS");
  EXPECT_EQ(threads_of("--threads 3"), 3);
  const Json all = threads_of("");
  EXPECT_GE(all.get<int>(), 1);
  EXPECT_EQ(threads_of("--threads all"), all);
  const Variable variable("5");
  EXPECT_EQ(threads_of(""), 5);
  EXPECT_EQ(threads_of("--threads 2"), 2);
  EXPECT_EQ(threads_of("--threads all"), all);
}

TEST(Threads, ThatAreNoneAreBadUsage) {
  write_file("torus.obj", wavy_torus(8));
  for (const char* bad : {"0", "-1", "2.5", "two", "1025", "1e9", "nan"}) {
    const test::Run option = run_batten(std::string("info torus.obj --threads=") + bad);
    EXPECT_EQ(option.exit_code, 2) << bad;
    EXPECT_NE(option.err.find("--threads must be all or a whole number from 1 to 1024"), std::string::npos)
        << option.err;
    const Variable variable(bad);
    const test::Run environment = run_batten("info torus.obj");
    EXPECT_EQ(environment.exit_code, 2) << bad;
    EXPECT_NE(environment.err.find("BATTEN_THREADS must be all or a whole number from 1 to 1024"),
              std::string::npos)
        << environment.err;
  }
  const Variable empty("");
  EXPECT_EQ(run_batten("info torus.obj").exit_code, 0);
}

// Whatever is done on several threads must not depend on how many there are: not in the last bit of a file.
TEST(Threads, DoNotChangeAByteOfWhatIsWritten) {
  write_file("torus.obj", wavy_torus(test::repeated(110, 60)));
  for (const std::string command : {"fair torus.obj --noise 0.2", "fair torus.obj --method mcf",
                                    "remesh torus.obj", "simplify torus.obj --remove 80%"}) {
    std::string one;
    for (const int threads : {1, 3}) {
      const std::string file = "out_" + std::to_string(threads) + ".ply";
      const test::Run run = run_batten(command + " -o " + file + " --threads " + std::to_string(threads));
      ASSERT_EQ(run.exit_code, 0) << command << run.err;
      const std::string bytes = read_file(file);
      EXPECT_GT(bytes.size(), 10000U);
      if (threads == 1) one = bytes;
      EXPECT_TRUE(bytes == one) << command << " on " << threads << " threads";
    }
  }
}

}  // namespace
}  // namespace batten::test
