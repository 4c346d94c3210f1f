#include "apps/run_json.hpp"

#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::test {
namespace {

using Json = nlohmann::json;

/// A closed bumpy torus of 2n × n quads as OFF.
std::string bumpy_torus(int n) {
  std::ostringstream off;
  off << "OFF\n" << 2 * n * n << ' ' << 4 * n * n << " 0\n";
  const double turn = 2 * std::acos(-1.0);
  for (int i = 0; i < 2 * n; ++i)
    for (int j = 0; j < n; ++j) {
      const double a = turn * i / (2 * n), b = turn * j / n;
      const double tube = 0.7 + 0.05 * std::sin(5 * a), r = 2 + tube * std::cos(b);
      off << r * std::cos(a) << ' ' << r * std::sin(a) << ' ' << tube * std::sin(b) << '\n';
    }
  for (int i = 0; i < 2 * n; ++i)
    for (int j = 0; j < n; ++j) {
      const int i1 = (i + 1) % (2 * n), j1 = (j + 1) % n;
      off << "3 " << i * n + j << ' ' << i1 * n + j << ' ' << i1 * n + j1 << "\n3 " << i * n + j << ' '
          << i1 * n + j1 << ' ' << i * n + j1 << '\n';
    }
  return off.str();
}

std::string folder(const std::string& name) {
  std::filesystem::create_directories(scratch() + "/" + name + "/meshes");
  return name;
}

// The rows and figures are those printed in H; each table has been counted there.
TEST(ReportCommand, PrintsTheTablesOfTheThesisWithoutAnyMesh) {
  const Json json = run_json("report thesis-h --data " + folder("nothing"));
  EXPECT_EQ(json["missing"].size(), 10U);
  EXPECT_TRUE(json["meshes"].empty());
  const Json& tables = json["tables"];
  EXPECT_EQ(tables["2.2"].size(), 9U);
  EXPECT_EQ(tables["2.3"].size(), 10U);
  EXPECT_EQ(tables["2.4"].size(), 12U);
  EXPECT_EQ(tables["2.5"].size(), 10U);
  for (const auto& [name, rows] : tables.items())
    for (const Json& row : rows) EXPECT_TRUE(row["ours"].is_null()) << name;
  EXPECT_EQ(tables["2.2"][0]["thesis"]["time_step"], 0.013);
  EXPECT_EQ(tables["2.3"][4]["mesh"], "fandisk");
  EXPECT_EQ(tables["2.5"][9]["thesis"]["drms"], 0.010267);

  const auto text = run_batten("report thesis-h --data nothing");
  EXPECT_EQ(text.exit_code, 0);
  for (const char* part : {"Table 2.2", "Table 2.5", "oilpump", "not at hand", "0.010267"})
    EXPECT_NE(text.out.find(part), std::string::npos) << part;
}

// A small closed mesh under a name that three of the tables have: all of it is measured and drawn.
TEST(ReportCommand, PutsOurFiguresBesideThemWhereAMeshIsAtHand) {
  const std::string data = folder("some");
  write_file(data + "/meshes/igea.off", bumpy_torus(12));
  const Json json = run_json("report thesis-h -o thesis.html --data " + data);
  EXPECT_EQ(json["meshes"].size(), 1U);
  EXPECT_EQ(json["meshes"]["igea"]["vertices"], 288);
  EXPECT_EQ(json["missing"].size(), 9U);
  int measured = 0;
  for (const auto& [name, rows] : json["tables"].items())
    for (const Json& row : rows) {
      ASSERT_EQ(row["ours"].is_null(), row["mesh"] != "igea") << name;
      if (row["ours"].is_null()) continue;
      ++measured;
      if (name == "2.2") {
        EXPECT_GT(row["ours"]["normal_error_deg"].get<double>(), 0) << name;
      }
      if (name == "2.3") {
        EXPECT_GT(row["ours"]["mean_distance"].get<double>(), 0) << name;
      }
      if (name == "2.5") {
        EXPECT_LT(row["ours"]["faces"].get<int>(), 576) << name;
        // Fewer faces cannot be nearer.
        EXPECT_LE(row["ours"]["dmean"].get<double>(), row["ours"]["dmax"].get<double>());
        EXPECT_FALSE(row["plaplacian"].is_null());
      }
    }
  EXPECT_EQ(measured, 5 + 2 + 2);  // noisy, MCF, SDF, NL-SDF, auto; AR, LF; 99 and 99.9 %
  // Table 2.2's volume of igea is that of a shape as large: the printed lengths over its diameter stand
  // there.
  for (const Json& row : json["tables"]["2.5"])
    EXPECT_EQ(row["thesis"].contains("relative"), row["mesh"] == "igea");

  const std::string page = read_file("thesis.html");
  for (const char* part : {"Table 2.3", "NL-SDF", "not at hand", "gargoyle", "data:image/png;base64"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  EXPECT_EQ(page.find("src=\"http"), std::string::npos) << "the report must be self-contained";
}

// A mesh that is no surface leaves empty places and says why; the rest of the report stands.
TEST(ReportCommand, GoesOnWhereAMeshIsRefused) {
  const std::string data = folder("bad");
  write_file(data + "/hand.off",
             "OFF\n5 3 0\n0 0 0\n1 0 0\n0 1 0\n0 -1 0\n0 0 1\n3 0 1 2\n3 1 0 3\n3 0 1 4\n");
  const Json json = run_json("report thesis-h --tables 2.3,2.5 -o bad.html --data " + data);
  EXPECT_NE(read_file("bad.html").find("--tables 2.3,2.5"), std::string::npos) << "the line that repeats it";
  EXPECT_EQ(json["tables"].size(), 2U);
  EXPECT_TRUE(json["tables"]["2.3"][0]["ours"].is_null());
  EXPECT_FALSE(json["warnings"].empty());
}

// The same model by two methods: a sphere has a truth, a session has none; a model that a method refuses has
// its reason there. Bounds of the issue: normals jump by at most half a degree, the mean is within 0.3 %.
TEST(ReportCommand, ComparesTheSurfacesOfSketchedModels) {
  const std::string data = folder("sessions");
  write_file(data + "/disc.jsonl",
             "{\"batten_session\":1,\"unit\":\"m\"}\n"
             "{\"op\":\"insert\",\"points\":[[0,0,0],[1,0,0],[1,1,0],[0,1,0]],\"closed\":true}\n");
  write_file(data + "/empty.jsonl", "{\"batten_session\":1,\"unit\":\"m\"}\n");
  const Json json = run_json("report sketch -o sketch.html --levels 2 --models sphere,disc,empty --methods " +
                             std::string("v2,curvature --data ") + data);
  ASSERT_EQ(json["models"].size(), 3U);
  EXPECT_EQ(json["models"][0]["model"], "sphere");
  EXPECT_EQ(json["models"][0]["genus"], 0);
  for (const char* method : {"v2", "curvature"}) {
    const Json& sphere = json["models"][0]["methods"][method];
    EXPECT_LT(sphere["continuity"]["smooth"]["max_normal_jump_deg"].get<double>(), 0.5) << method;
    EXPECT_GT(sphere["continuity"]["smooth"]["samples"].get<int>(), 100) << method;
    EXPECT_LT(sphere["deviation"]["mean"].get<double>(), 3e-3) << method;
    EXPECT_LE(sphere["deviation"]["mean"].get<double>(), sphere["deviation"]["max"].get<double>()) << method;
    EXPECT_FALSE(json["models"][2]["methods"][method]["refused"].get<std::string>().empty()) << method;
  }
  const Json& disc = json["models"][1]["methods"]["v2"];
  EXPECT_TRUE(disc["deviation"].is_null());
  EXPECT_TRUE(disc["continuity"]["smooth"].is_null()) << "all of its curves are borders";
  const std::string page = read_file("sketch.html");
  for (const char* part : {"sphere by v2", "sphere by curvature", "refused: ", "data:image/png;base64"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  EXPECT_EQ(run_batten("report sketch --models nothing --data " + data).exit_code, 3);
  EXPECT_EQ(run_batten("report sketch --methods v9 --data " + data).exit_code, 2);
}

TEST(ReportCommand, TellsBadUsageFromBadInput) {
  EXPECT_EQ(run_batten("report").exit_code, 2);
  EXPECT_EQ(run_batten("report thesis-x").exit_code, 2);
  EXPECT_EQ(run_batten("report thesis-h --tables 9.9").exit_code, 2);
  EXPECT_EQ(run_batten("report thesis-h -o page.pdf").exit_code, 2);
  const auto missing = run_batten("report thesis-h --data nowhere");
  EXPECT_EQ(missing.exit_code, 3);
  EXPECT_NE(missing.err.find("nowhere"), std::string::npos);
  write_file(folder("broken") + "/foot.off", "OFF\nnonsense\n");
  EXPECT_EQ(run_batten("report thesis-h --tables 2.3 --data broken").exit_code, 3);
}

}  // namespace
}  // namespace batten::test
