#include "apps/run_batten.hpp"
#include "sanitizers.hpp"

#include <algorithm>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::test {
namespace {

std::set<std::string> files() {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(scratch()))
    names.insert(entry.path().filename());
  names.erase(".stdout"), names.erase(".stderr");
  return names;
}

/// Bad input ends with 3 (bad usage with 2), nothing on stdout, one sentence on stderr that holds every word
/// given, no new file.
void expect_refused(const std::string& arguments, const std::vector<std::string>& words, int exit_code = 3) {
  SCOPED_TRACE("batten " + arguments);
  const std::set<std::string> before = files();
  const auto run = run_batten(arguments);
  EXPECT_EQ(run.exit_code, exit_code) << run.err;
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(run.err.rfind("batten: ", 0), 0U) << run.err;
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  for (const std::string& word : words) EXPECT_NE(run.err.find(word), std::string::npos) << word << run.err;
  EXPECT_EQ(files(), before) << "nothing may be left behind";
}

/// A circle of eight chords' readings with two nodes on the border, and its diameter.
const std::vector<std::string>& good_scan() {
  static const std::vector<std::string> lines{"2",  // line 1: number of curves
                                              "1",
                                              "1",
                                              "3",
                                              "1 5 9",
                                              "0 1 0",
                                              "9",
                                              "0 0 1 0 0 0 1",  // line 8: the first reading of curve 1
                                              "0.785 -0.707 0.707 0 0 0 1",
                                              "1.571 -1 0 0 0 0 1",
                                              "2.356 -0.707 -0.707 0 0 0 1",
                                              "3.142 0 -1 0 0 0 1",
                                              "3.927 0.707 -0.707 0 0 0 1",
                                              "4.712 1 0 0 0 0 1",
                                              "5.498 0.707 0.707 0 0 0 1",
                                              "6.283 0 1 0 0 0 1",
                                              "0",  // line 17: curve 2
                                              "0",
                                              "2",
                                              "1 3",
                                              "0 1",
                                              "3",
                                              "0 -1 0 0 0 0 1",  // line 23
                                              "1 -1 0 0 0 0 1",
                                              "2 -1 0 0 0 0 1"};
  return lines;
}

std::string text(const std::vector<std::string>& lines) {
  std::string all;
  for (const std::string& line : lines) all += line + "\n";
  return all;
}

/// The good scan with some lines replaced, numbered from 1.
std::string scan_with(const std::vector<std::pair<int, std::string>>& changes) {
  std::vector<std::string> lines = good_scan();
  for (const auto& [line, change] : changes) lines[line - 1] = change;
  return text(lines);
}

// Without this the refusals below could have any other cause.
TEST(BadInput, TheScanThatIsSpoiltBelowIsGood) {
  write_file("good.rawnet", text(good_scan()));
  const auto run = run_batten("network good.rawnet -o good_network.json --step none --weights 0,0");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_TRUE(file_exists("good_network.json"));
}

TEST(BadInput, EveryTruncatedScanIsRefusedAtItsEnd) {
  const std::vector<std::string>& lines = good_scan();
  for (size_t n = 0; n < lines.size(); ++n) {
    write_file("bad.rawnet", text({lines.begin(), lines.begin() + static_cast<long>(n)}));
    expect_refused("network bad.rawnet -o out.json", {"bad.rawnet:"});
  }
  write_file("bad.rawnet", text(good_scan()).substr(0, text(good_scan()).size() - 6));  // within a row
  expect_refused("network bad.rawnet -o out.json", {"bad.rawnet:25", "7"});
}

struct SpoiltScan {
  const char* name;
  std::vector<std::pair<int, std::string>> changes;
  std::vector<std::string> words;
};

TEST(BadInput, SpoiltScansAreRefusedWithFileLineAndCause) {
  const std::vector<SpoiltScan> cases{
      {"more curves announced than there are", {{1, "3"}}, {"bad.rawnet:26", "curve 3 of 3"}},
      {"fewer curves announced than there are", {{1, "1"}}, {"bad.rawnet:17", "number of curves"}},
      {"no curves, or a list of files that is none", {{1, "0"}}, {"bad.rawnet:3"}},
      {"a negative count", {{1, "-2"}}, {"bad.rawnet:1"}},
      {"a count beyond any file", {{7, "99999999999999999999"}}, {"bad.rawnet:7"}},
      {"one reading too many announced", {{7, "10"}}, {"bad.rawnet:17"}},
      {"one reading too few announced", {{7, "8"}}, {"bad.rawnet:"}},
      {"one node too many announced", {{4, "4"}}, {"bad.rawnet:5"}},
      {"a node at a reading that is not there", {{5, "1 5 10"}}, {"bad.rawnet:", "10"}},
      {"a node at reading 0", {{5, "0 5 9"}}, {"bad.rawnet:"}},
      {"a node number out of range", {{6, "0 7 0"}}, {"bad.rawnet", "7"}},
      {"nodes that run backwards", {{5, "5 1 9"}}, {"bad.rawnet:", "increas"}},
      {"not a number", {{10, "1.571 nan 0 0 0 0 1"}}, {"bad.rawnet:10"}},
      {"infinity", {{10, "1.571 -1 inf 0 0 0 1"}}, {"bad.rawnet:10"}},
      {"a word", {{10, "1.571 -1 zero 0 0 0 1"}}, {"bad.rawnet:10", "zero"}},
      {"a zero tangent", {{10, "1.571 0 0 0 0 0 1"}}, {"bad.rawnet:10", "tangent"}},
      {"a zero normal", {{10, "1.571 -1 0 0 0 0 0"}}, {"bad.rawnet:10", "normal"}},
      {"tangent along the normal", {{10, "1.571 0 0 1 0 0 1"}}, {"bad.rawnet:10", "parallel"}},
      {"decreasing distance", {{10, "0.5 -1 0 0 0 0 1"}}, {"bad.rawnet:10", "distance"}},
      {"a reading with too few numbers", {{10, "1.571 -1 0 0 0 0"}}, {"bad.rawnet:10"}},
      {"a reading with too many numbers", {{10, "1.571 -1 0 0 0 0 1 9"}}, {"bad.rawnet:10"}},
      {"parts that do not touch", {{6, "0 1 0"}, {21, "2 3"}}, {"curve 2", "not connected"}},
      {"a closed curve that ends elsewhere", {{6, "0 1 1"}}, {"curve 1"}},
      {"a flag that is neither", {{2, "3"}}, {"bad.rawnet:2"}},
  };
  for (const SpoiltScan& spoilt : cases) {
    SCOPED_TRACE(spoilt.name);
    write_file("bad.rawnet", scan_with(spoilt.changes));
    expect_refused("network bad.rawnet -o out.json", spoilt.words);
  }
}

TEST(BadInput, AScanWithoutCurvesIsRefused) {
  write_file("bad.rawnet", "# nothing yet\n0\n");
  expect_refused("network bad.rawnet -o out.json", {"bad.rawnet:", "no curves"});
}

TEST(BadInput, ACurveWithOneReadingIsRefused) {
  write_file("bad.rawnet", "1\n0\n0\n1\n1\n0\n1\n0 1 0 0 0 0 1\n");
  expect_refused("network bad.rawnet -o out.json", {"bad.rawnet:7", "curve 1", "at least 2"});
}

// All readings at one place: there is no curve, whatever the orientations say.
TEST(BadInput, ACurveWithoutLengthIsRefused) {
  write_file("bad.rawnet", "1\n0\n0\n0\n2\n1 1 0 0 0 0 1\n1 0 1 0 0 0 1\n");
  expect_refused("network bad.rawnet -o out.json", {"curve 1"});
}

TEST(BadInput, EveryCommandRefusesEmptyFilesFoldersGarbageAndNothing) {
  std::string garbage;
  for (unsigned i = 1, x = 12345; i <= 3000; ++i) {
    x = 1664525 * x + 1013904223;
    garbage += static_cast<char>(x >> 24);
  }
  const std::vector<std::pair<std::string, std::vector<std::string>>> commands{
      {"network", {"rawnet", "csv"}},
      {"reconstruct", {"rawnet", "csv"}},
      {"calibrate", {"csv"}},
      {"orient", {"csv"}},
      {"surface", {"net", "obj", "json", "txt"}},
      {"info", {"rawnet", "csv", "ply", "off", "stl", "obj", "net", "json", "txt"}},
      {"render", {"ply", "off", "obj"}},
      {"convert", {"ply", "stl", "net"}},
      {"compare", {"ply", "off", "net"}},
      {"check", {"ply", "off", "net"}},
      {"fair", {"ply", "off", "stl", "obj"}},
      {"remesh", {"ply", "off", "stl", "obj"}},
      {"simplify --faces 10", {"ply", "off", "stl", "obj"}},
      {"deform --handles handles.json", {"ply", "off", "stl", "obj"}},
      {"simulate", {"ply", "off", "stl", "obj"}}};
  write_file("handles.json", "{\"fixed\": {\"vertices\": [0]}, \"handles\": []}");
  const auto line_for = [](const std::string& command, const std::string& input) {
    if (command == "info") return "info " + input;
    if (command == "convert") return "convert " + input + " out.json";
    if (command == "compare") return "compare " + input + " " + input;
    if (command == "check") return "check " + input + " --network " + input;
    const std::string output = command == "render"                              ? "out.png"
                               : command == "simulate"                          ? "out.rawnet"
                               : command == "orient"                            ? "out.csv"
                               : command == "network" || command == "calibrate" ? "out.json"
                                                                                : "out.ply";
    return command + " " + input + " -o " + output;
  };
  for (const auto& [command, extensions] : commands) {
    for (const std::string& extension : extensions) {
      write_file("empty." + extension, "");
      write_file("garbage." + extension, garbage);
      std::filesystem::create_directories(scratch() + "/folder." + extension);
      for (const std::string stem : {"garbage.", "empty.", "folder.", "missing."})
        if (!test::kSanitized || stem == "garbage.")
          expect_refused(line_for(command, stem + extension), {stem + extension});
    }
  }
}

TEST(BadInput, SpoiltMeshesAreRefusedWithTheirPlace) {
  const std::string square = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  struct Spoilt {
    std::string off;
    std::vector<std::string> words;
  };
  const std::vector<Spoilt> meshes{
      {"OFF\n4 0 0\n" + square, {"bad.off", "no faces"}},
      {"OFF\n4 1 0\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n3 0 1 2\n", {"bad.off", "no face has an area"}},
      {"OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n", {"bad.off", "no face has an area"}},
      {"OFF\n3 1 0\n0 0 0\n1e200 0 0\n0 1e200 0\n3 0 1 2\n", {"bad.off", "another unit"}},
      {"OFF\n3 1 0\n0 0 0\n1e-200 0 0\n0 1e-200 0\n3 0 1 2\n", {"bad.off", "another unit"}},
      {"OFF\n3 1 0\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n", {"bad.off:4", "nan"}},
      {"OFF\n4 2 0\n" + square + "3 0 1 2\n3 0 2 9\n", {"bad.off:8", "9"}},
      {"OFF\n4 2 0\n" + square + "3 0 1 2\n", {"bad.off", "face"}},
      // The second face is turned inside out; three faces at the edge 0-1.
      {"OFF\n4 2 0\n" + square + "3 0 1 2\n3 0 3 2\n", {"0", "2", "same direction"}},
      {"OFF\n5 3 0\n" + square + "0 0 1\n3 0 1 2\n3 1 0 3\n3 0 1 4\n", {"0", "1", "same direction"}}};
  write_file("handles.json", "{\"fixed\": {\"vertices\": [0]}, \"handles\": []}");
  for (const Spoilt& mesh : meshes) {
    write_file("bad.off", mesh.off);
    for (const char* command : {"fair", "remesh", "simplify --remove 50%", "deform --handles handles.json"})
      expect_refused(std::string(command) + " bad.off -o out.ply", mesh.words);
  }
}

TEST(BadInput, SpoiltNetworksAreRefused) {
  // A square with an index beyond the vertices, with a coordinate that is no number, with three sides only, …
  const std::string points = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  const std::string normals = "vn 0 0 1\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\n";
  write_file("bad.obj", points + normals + "l 1 2 3 9\n");
  expect_refused("surface bad.obj -o out.ply", {"bad.obj:9", "9"});
  write_file("bad.obj", points + normals + "l 1 2 3 0\n");
  expect_refused("surface bad.obj -o out.ply", {"bad.obj:9"});
  write_file("bad.obj", "v 0 0 0\nv 1 nan 0\nv 1 1 0\n" + normals + "l 1 2 3 1\n");
  expect_refused("surface bad.obj -o out.ply", {"bad.obj:2"});
  // Without normals it is a sketch, which an open one does not bound.
  write_file("bad.obj", points + "l 1 2 3 4\n");
  expect_refused("surface bad.obj -o out.ply", {"closed cycle"});
  write_file("bad.obj", points + normals);
  expect_refused("surface bad.obj -o out.ply", {"bad.obj"});
  // One curve that dangles bounds nothing.
  write_file("bad.obj", points + normals + "l 1 2 3\n");
  expect_refused("surface bad.obj -o out.ply", {"curve"});
  write_file("bad.json", R"({"format": "batten-network", "version": 1, "positions": [[0,0,0],[1,0,0]],
    "normals": [[0,0,1]], "curves": [{"vertices": [0, 1]}]})");
  expect_refused("surface bad.json -o out.ply", {"bad.json", "normals"});
  write_file("bad.json", R"({"format": "batten-network", "version": 1, "positions": [[0,0,0],[1,0,0]],
    "curves": [{"vertices": [0, 7]}]})");
  expect_refused("surface bad.json -o out.ply", {"bad.json", "7"});
  write_file("bad.json", R"({"format": "batten-network", "version": 1, "positions": [[0,0,0],[1,0)");
  expect_refused("surface bad.json -o out.ply", {"bad.json"});
}

TEST(BadInput, OutputThatCannotBeWrittenIsToldAndLeavesNothing) {
  write_file("good.rawnet", text(good_scan()));
  write_file("t.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  std::filesystem::create_directories(scratch() + "/taken.json");
  expect_refused("network good.rawnet --step none --weights 0,0 -o no/such/folder/net.json", {"net.json"});
  expect_refused("network good.rawnet --step none --weights 0,0 -o taken.json", {"taken.json", "folder"});
  for (const char* line :
       {"network good.rawnet -o out.xyz", "surface good.rawnet -o out.xyz",
        "reconstruct good.rawnet -o out.xyz", "reconstruct good.rawnet -o out.ply --network out.xyz"})
    expect_refused(line, {"out.xyz", "extension"}, 2);
  expect_refused("simulate sphere --step 5% -o no/such/folder/scan.rawnet", {"scan.rawnet"});
  expect_refused("convert t.off no/such/folder/t.ply", {"t.ply"});
  expect_refused("render t.off --size 40x40 -o no/such/folder/t.png", {"t.png"});
  expect_refused("info t.off --report no/such/folder/report.html", {"report.html"});
}

TEST(BadInput, ReportsOfThesesNameFoldersAndRows) {
  std::filesystem::create_directories(scratch() + "/data");
  write_file("data/empty.off", "OFF\n0 0 0\n");
  expect_refused("report thesis-s --data nowhere", {"nowhere", "--data"});
  expect_refused("report thesis-h --data data/empty.off", {"empty.off", "--data"});
  expect_refused("report thesis-h-fires --rows 7.7 --data data --sessions nowhere",
                 {"nowhere", "--sessions"});
  expect_refused("report thesis-s --rows 9.9 --data data", {"9.9", "--rows", "thesis-s"});
}

// A reader that copies or searches quadratically would not come back from this in the time of the test.
TEST(BadInput, ALongScanIsReadToItsWrongEnd) {
  constexpr int kReadings = 200000;
  std::ostringstream long_scan;
  long_scan << "1\n0\n0\n0\n" << kReadings << "\n";
  for (int i = 0; i + 1 < kReadings; ++i) long_scan << i << " 1 0 0 0 0 1\n";
  write_file("long.rawnet", long_scan.str() + "0 1 0 0 0 0 1\n");
  expect_refused("network long.rawnet -o out.json", {"long.rawnet:200005", "distance"});
}

TEST(BadUsage, EndsWithTwoAndSaysWhatIsWrong) {
  write_file("good.rawnet", text(good_scan()));
  for (const char* usage : {"",
                            "sew",
                            "network",
                            "network good.rawnet",
                            "network good.rawnet -o",
                            "network good.rawnet -o out.json --step 0",
                            "network good.rawnet -o out.json --step -1%",
                            "network good.rawnet -o out.json --step wide",
                            "network good.rawnet -o out.json --weights 1",
                            "network good.rawnet -o out.json --weights -1,1",
                            "network good.rawnet -o out.json --energy big",
                            "network good.rawnet -o out.json --xi -1",
                            "network good.rawnet -o out.json --robust maybe",
                            "network good.rawnet -o out.json --scheme euler",
                            "network good.rawnet -o out.json --lengths guessed",
                            "network good.rawnet -o out.json --lengths estimated --weights thesis",
                            "network good.rawnet -o out.json --no-such-option",
                            "surface n.net -o out.ply --rebuilds -1",
                            "surface n.net -o out.ply --rebuilds many",
                            "surface n.net -o out.ply --topology best",
                            "surface n.net -o out.ply --closed maybe",
                            "surface n.net -o out.ply --symmetry w",
                            "surface n.net -o out.ply --method cubic",
                            "surface n.net -o out.ply --constraints loose",
                            "surface n.net -o out.ply --soft-weight -1",
                            "surface n.net -o out.ply --map globe",
                            "reconstruct good.rawnet",
                            "simulate sphere",
                            "simulate dodecahedron -o out.rawnet",
                            "simulate sphere -o out.xyz",
                            "simulate sphere -o out.rawnet --seed x",
                            "simulate sphere -o out.rawnet --outliers 150%",
                            "simulate sphere -o out.rawnet --orientation-noise 2mm",
                            "simulate sphere -o out.rawnet --step 0",
                            "compare a.ply",
                            "check a.ply",
                            "check a.ply --network n.net --continuity g3",
                            "info",
                            "convert a.ply",
                            "calibrate good.csv",
                            "orient good.csv",
                            "render a.ply"}) {
    SCOPED_TRACE(std::string("batten ") + usage);
    const std::set<std::string> before = files();
    const auto run = run_batten(usage);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_EQ(run.out, "");
    EXPECT_NE(run.err, "");
    EXPECT_EQ(files(), before);
  }
}

// With --json an error is one object on standard output, whatever stage it comes from.
TEST(BadInput, ErrorsAreOneJsonObject) {
  write_file("empty.ply", "");
  write_file("broken.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 x 0\n3 0 1 2\n");
  struct Case {
    const char *line, *code, *file;
    int exit_code;
    long at;
    bool has_remedy;
  };
  for (const Case& c :
       {Case{"fair none.ply -o out.ply --json", "input", "none.ply", 3, 0, false},
        Case{"fair broken.off -o out.ply --json", "input", "broken.off", 3, 5, false},
        Case{"fair broken.off -o out.xyz --json", "usage", "out.xyz", 2, 0, true},
        Case{"fair broken.off -o out.ply --iteratoins 3 --json", "usage", nullptr, 2, 0, true},
        Case{"simplify broken.off --json", "usage", nullptr, 2, 0, true}}) {
    SCOPED_TRACE(c.line);
    const auto run = run_batten(c.line);
    EXPECT_EQ(run.exit_code, c.exit_code);
    const auto json = nlohmann::json::parse(run.out, nullptr, false);
    ASSERT_TRUE(json.is_object() && json.size() == 1 && json.contains("error")) << run.out;
    const auto& error = json["error"];
    EXPECT_EQ(error["code"], c.code);
    EXPECT_EQ("batten: " + error["message"].get<std::string>() + "\n", run.err);
    if (c.file != nullptr) {
      EXPECT_EQ(error["file"], c.file);
    } else {
      EXPECT_TRUE(error["file"].is_null());
    }
    EXPECT_EQ(error["line"].is_null() ? 0 : error["line"].get<long>(), c.at);
    EXPECT_EQ(error["remedy"].is_string(), c.has_remedy);
  }
}

TEST(BadInput, MistypedNamesNameTheNearest) {
  for (const auto& [line, word] :
       {std::pair{"fari x.ply -o y.ply", "did you mean fair?"},
        {"remsh x.ply", "did you mean remesh?"},
        {"fair x.ply --otput y.ply", "did you mean --output?"},
        {"simplify x.ply --keep-edgs=30deg -o y.ply", "did you mean --keep-edges?"},
        {"frobnicate x.ply", "batten --help"},
        {"fair x.ply -o y.ply --frobnicate 3", "batten fair --help"}}) {
    const auto run = run_batten(line);
    EXPECT_EQ(run.exit_code, 2) << line;
    EXPECT_NE(run.err.find(word), std::string::npos) << line << ": " << run.err;
  }
}

TEST(BadInput, QuietRunsSayNothingButErrors) {
  write_file("tetra.off", "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n");
  const auto run = run_batten("convert tetra.off tetra.stl --quiet");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out + run.err, "");
  EXPECT_TRUE(file_exists("tetra.stl"));
  EXPECT_NE(run_batten("convert none.off tetra.stl --quiet").err, "");
}

// 1e300 fits none of the numbers that binary STL has; the old file stays.
TEST(BadInput, NumbersThatAFormatCannotHoldAreRefused) {
  write_file("far.off", "OFF\n3 1 0\n0 0 0\n1e300 0 0\n0 1 0\n3 0 1 2\n");
  write_file("far.stl", "old");
  const auto run = run_batten("convert far.off far.stl");
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("3.40282e+38"), std::string::npos) << run.err;
  EXPECT_EQ(read_file("far.stl"), "old");
}

}  // namespace
}  // namespace batten::test
