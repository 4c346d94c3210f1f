#include "apps/run_batten.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::test {
namespace {

using Json = nlohmann::json;

/// A torus of n × 2n vertices with the radii 1 and 0.4, as OFF.
std::string torus(int n) {
  const int m = 2 * n;
  std::string text = "OFF\n" + std::to_string(n * m) + " " + std::to_string(2 * n * m) + " 0\n";
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < n; ++j) {
      const double u = 2 * M_PI * i / m, v = 2 * M_PI * j / n, r = 1 + 0.4 * std::cos(v);
      text += std::to_string(r * std::cos(u)) + " " + std::to_string(r * std::sin(u)) + " " +
              std::to_string(0.4 * std::sin(v)) + "\n";
    }
  for (int i = 0; i < m; ++i)
    for (int j = 0; j < n; ++j) {
      const auto at = [&](int p, int q) { return std::to_string((p % m) * n + q % n); };
      text += "3 " + at(i, j) + " " + at(i + 1, j) + " " + at(i + 1, j + 1) + "\n3 " + at(i, j) + " " +
              at(i + 1, j + 1) + " " + at(i, j + 1) + "\n";
    }
  return text;
}

TEST(SimplifyCommand, SaysWhatIsLeftAndHowFarItIsFromTheInput) {
  write_file("torus.off", torus(24));  // 2304 faces
  const auto run = run_batten("simplify torus.off -o small.ply --remove 75% --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json json = Json::parse(run.out);
  EXPECT_EQ(json["input_faces"], 2304);
  EXPECT_LE(json["faces"].get<int>(), 576);
  EXPECT_GE(json["faces"].get<int>(), 574);
  EXPECT_EQ(json["self_intersections"], 0);
  // What the command says must be what compare measures.
  const auto compared = run_batten("compare torus.off small.ply --json");
  ASSERT_EQ(compared.exit_code, 0) << compared.err;
  const Json relative = Json::parse(compared.out)["relative"];
  EXPECT_NEAR(json["input_to_result"]["drms"].get<double>(),
              relative["a_to_b"]["samples"]["rms"].get<double>(), 1e-5);
  EXPECT_NEAR(json["result_to_input"]["drms"].get<double>(),
              relative["b_to_a"]["samples"]["rms"].get<double>(), 1e-5);
}

TEST(SimplifyCommand, TakesEveryOption) {
  write_file("torus.off", torus(10));
  for (const char* options :
       {"--faces 200 --keep-edges 30deg --keep-border exact", "--error 4%", "--error 0.1 --method quadric",
        "--remove 60% --method plaplacian --p 0.5 --alpha 1 --beta 0.5 --weight w1 --fidelity adaptive",
        "--remove 60% --method plaplacian --weight w2 --fidelity 10",
        "--remove 60% --method plaplacian --weight w3 --sigma 0.3 --levels 2"}) {
    const auto run = run_batten(std::string("simplify torus.off -o out.obj --json ") + options);
    ASSERT_EQ(run.exit_code, 0) << options << run.err;
    EXPECT_LT(Json::parse(run.out)["faces"], 400) << options;
  }
}

// Every vertex of a level names the vertex of the next level that stands for it.
TEST(SimplifyCommand, WritesAllLevelsWithMapsBetweenThem) {
  write_file("torus.off", torus(16));
  const auto run =
      run_batten("simplify torus.off -o out.ply --faces 200 --levels 3 --keep-all-levels levels --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(Json::parse(run.out)["levels"].size(), 4U);
  for (int level = 0; level < 4; ++level)
    EXPECT_TRUE(file_exists("levels/level_" + std::to_string(level) + ".ply")) << level;
  const std::string text = read_file("levels/level_0.ply");
  EXPECT_NE(text.substr(0, 1000).find("coarser_vertex"), std::string::npos);
}

TEST(SimplifyCommand, TellsBadUsageFromBadInput) {
  write_file("torus.off", torus(8));
  for (const char* options : {"", "--faces 10 --remove 50%", "--remove 120%", "--faces x", "--error -1",
                              "--faces 10 --method magic", "--faces 10 --levels 0"})
    EXPECT_EQ(run_batten(std::string("simplify torus.off -o none.ply ") + options).exit_code, 2) << options;
  EXPECT_EQ(run_batten("simplify missing.off -o none.ply --faces 10").exit_code, 3);
  EXPECT_FALSE(file_exists("none.ply"));
}

}  // namespace
}  // namespace batten::test
