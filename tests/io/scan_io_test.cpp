#include "batten/io/scan_io.hpp"

#include "io/bad_files.hpp"
#include "scratch.hpp"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "batten/core/text.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate.hpp"

namespace batten {
namespace {

using namespace test;

void expect_equal(const Scan& a, const Scan& b) {
  EXPECT_EQ(a.unit, b.unit);
  EXPECT_EQ(a.tangents, b.tangents);
  ASSERT_EQ(a.curves.size(), b.curves.size());
  for (size_t c = 0; c < a.curves.size(); ++c) {
    EXPECT_EQ(a.curves[c].name, b.curves[c].name);
    EXPECT_EQ(a.curves[c].boundary, b.curves[c].boundary);
    EXPECT_EQ(a.curves[c].closed, b.curves[c].closed);
    EXPECT_EQ(a.curves[c].node_readings, b.curves[c].node_readings);
    EXPECT_EQ(a.curves[c].node_ids, b.curves[c].node_ids);
    EXPECT_EQ(a.curves[c].distances, b.curves[c].distances);
    EXPECT_EQ(a.curves[c].tangents, b.curves[c].tangents);
    EXPECT_EQ(a.curves[c].normals, b.curves[c].normals);
  }
}

/// A straight curve of two readings along x.
const char* const kLine =
    "1\n"
    "0 # interior\n"
    "0\n"
    "2\n"
    "1 2\n"
    "0 1\n"
    "2\n"
    "+0.0 +1 0 0  0 0 1\n"
    "+2.5 +1 0 0  0 0 1\n";

TEST(Rawnet, ASharpCurveIsReadAndWritten) {
  const Scan scan = parse_rawnet(replaced(kLine, "0 # interior", "2"), "line.rawnet");
  EXPECT_TRUE(scan.curves[0].sharp);
  EXPECT_FALSE(scan.curves[0].boundary);
  const std::string path = test::scratch_file("sharp.rawnet");
  write_rawnet(scan, path);
  EXPECT_TRUE(read_rawnet(path).curves[0].sharp);
  EXPECT_FALSE(parse_rawnet(kLine, "line.rawnet").curves[0].sharp);
}

TEST(Rawnet, ReadsWhatTheFileSays) {
  const Scan scan = parse_rawnet(kLine, "line.rawnet");
  ASSERT_EQ(scan.curves.size(), 1U);
  const ScanCurve& curve = scan.curves[0];
  EXPECT_FALSE(curve.boundary);
  EXPECT_FALSE(curve.closed);
  EXPECT_EQ(curve.node_readings, (std::vector<int>{0, 1}));
  EXPECT_EQ(curve.node_ids, (std::vector<int>{0, 1}));
  EXPECT_EQ(curve.distances, Eigen::Vector2d(0, 2.5));
  EXPECT_EQ(curve.tangents.row(1), Eigen::RowVector3d(1, 0, 0));
  EXPECT_EQ(curve.normals.row(1), Eigen::RowVector3d(0, 0, 1));
}

TEST(Rawnet, NodesWithoutNumbersAreReadAndWritten) {
  const Scan scan = parse_rawnet(replaced(kLine, "0 1\n", "? ?\n"), "line.rawnet");
  EXPECT_EQ(scan.curves[0].node_ids, (std::vector<int>{kNoNodeNumber, kNoNodeNumber}));
  const std::string path = test::scratch_file("stays.rawnet");
  write_rawnet(scan, path);
  expect_equal(read_rawnet(path), scan);
  EXPECT_THROW(check_scan(scan), InvalidInput);
  EXPECT_NO_THROW(check_scan(scan, NodeNumbers::MayMiss));
  // Without marks the curves are not connected, which only those want to read who look for the nodes.
  Scan bare = scan;
  bare.curves.push_back(bare.curves[0]);
  for (ScanCurve& curve : bare.curves) curve.node_readings.clear(), curve.node_ids.clear();
  write_rawnet(bare, path);
  EXPECT_THROW(read_rawnet(path), FileError);
  expect_equal(read_rawnet(path, NodeNumbers::MayMiss), bare);
  // Some numbers may be there; they are checked as ever.
  EXPECT_EQ(parse_rawnet(replaced(kLine, "0 1\n", "? 0\n"), "line.rawnet").curves[0].node_ids[1], 0);
  EXPECT_THROW(parse_rawnet(replaced(kLine, "0 1\n", "? 7\n"), "line.rawnet"), FileError);
  EXPECT_THROW(parse_rawnet(replaced(kLine, "1 2\n", "? 2\n"), "line.rawnet"), FileError);
}

// Comments, blank lines, blanks at the ends, Windows line ends and a byte-order mark carry no meaning.
TEST(Rawnet, LooksThroughCommentsBlanksAndLineEnds) {
  const Scan plain = parse_rawnet(kLine, "a");
  std::string windows;
  for (const char c : std::string(kLine)) windows += c == '\n' ? std::string("\t\r\n") : std::string(1, c);
  expect_equal(parse_rawnet(windows, "b"), plain);
  expect_equal(
      parse_rawnet("\xEF\xBB\xBF# x\n\n  # y\n" + replaced(kLine, "2\n1 2", "# nodes\n2\n\n1 2 # local"),
                   "c"),
      plain);
  std::string no_end(kLine);
  no_end.pop_back();
  expect_equal(parse_rawnet(no_end, "d"), plain);
}

TEST(Rawnet, TakesNodeNumbersFromZeroAndFromOne) {
  EXPECT_EQ(parse_rawnet(replaced(kLine, "0 1\n2", "1 2\n2"), "a").curves[0].node_ids,
            (std::vector<int>{1, 2}));
  EXPECT_EQ(parse_rawnet(kLine, "b").curves[0].node_ids, (std::vector<int>{0, 1}));
}

TEST(Rawnet, TakesCurvesWithoutNodes) {
  const Scan scan = parse_rawnet(replaced(kLine, "2\n1 2\n0 1\n", "0\n"), "a");
  EXPECT_TRUE(scan.curves[0].node_ids.empty());
  EXPECT_EQ(scan.curves[0].n_readings(), 2);
}

TEST(Rawnet, UnderstandsUnitNameAndTangentComments) {
  const std::string text = replaced("# unit: mm\n# tangents: to-next\n" + std::string(kLine), "0 # interior",
                                    "# name: keel line\n0");
  const Scan scan = parse_rawnet(text, "a");
  EXPECT_EQ(scan.unit, "mm");
  EXPECT_EQ(scan.tangents, TangentConvention::ToNext);
  EXPECT_EQ(scan.curves[0].name, "keel line");
  EXPECT_EQ(parse_rawnet(kLine, "b").tangents, TangentConvention::Auto);
  // A name is that of one curve.
  const std::string block(std::string(kLine).substr(2));
  const Scan two = parse_rawnet("2\n# name: keel line\n" + block + replaced(block, "0 1\n2", "1 2\n2"), "c");
  EXPECT_EQ(two.curves[0].name, "keel line");
  EXPECT_EQ(two.curves[1].name, "");
}

TEST(Rawnet, NormalisesDirections) {
  const Scan scan = parse_rawnet(replaced(kLine, "+2.5 +1 0 0", "+2.5 +3 4 0"), "a");
  EXPECT_EQ(scan.curves[0].tangents.row(1), Eigen::RowVector3d(0.6, 0.8, 0));
  EXPECT_EQ(parse_rawnet(replaced(kLine, "+2.5 +1 0 0", "+2.5 1.0005 0 0"), "b").curves[0].tangents.row(1),
            Eigen::RowVector3d(1, 0, 0));
}

// Who stands still while recording reads the same distance twice.
TEST(Rawnet, TakesReadingsAtOneDistance) {
  const Scan scan = parse_rawnet(replaced(replaced(kLine, "2\n+0.0", "3\n+0.0"), "+2.5 +1 0 0  0 0 1\n",
                                          "2.5 1 0 0 0 0 1\n2.5 1 0 0 0 0 1\n"),
                                 "a");
  EXPECT_EQ(scan.curves[0].distances, Eigen::Vector3d(0, 2.5, 2.5));
}

// What is wrong in a curve that began well is not put down to the one before.
TEST(Rawnet, BlamesTheCurveBeforeOnlyWhereTheNextDoesNotBegin) {
  const std::string block(std::string(kLine).substr(2));
  const auto said = [&](const std::string& second) {
    try {
      parse_rawnet("2\n" + block + second, "a");
    } catch (const FileError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(said("5\n0\n").find("curve 1 was to have 2 readings"), std::string::npos);
  EXPECT_NE(said("0\n5\n").find("closed flag"), std::string::npos);
  EXPECT_EQ(said("0\n5\n").find("curve 1 was to have"), std::string::npos) << said("0\n5\n");
}

// Any scan, written and read, is the same to the last bit; so is a second round of the file.
TEST(Rawnet, WritingAndReadingLosesNothing) {
  SimulateOptions options;
  options.orientation_noise = 0.03;
  options.odometer_error = 0.01;
  Scan scan = simulate_scan(trace_shape(AnalyticShape::Dish), options).scan;
  scan.unit = "mm";
  scan.curves[1].name = "a name, with #signs";
  const std::string path = test::scratch_file("round.rawnet");
  write_rawnet(scan, path);
  expect_equal(read_rawnet(path), scan);
  expect_equal(read_scan(path).scan, scan);
}

TEST(Rawnet, ReadsOneFilePerCurve) {
  const std::string block(std::string(kLine).substr(2));
  std::ofstream(test::scratch_file("one.txt")) << block;
  std::ofstream(test::scratch_file("two.txt")) << replaced(block, "0 1\n2", "1 2\n2");
  const std::string path = test::scratch_file("list.rawnet");
  std::ofstream(path) << "0 # a list\n2\none.txt\ntwo.txt\n";
  const Scan scan = read_rawnet(path);
  ASSERT_EQ(scan.curves.size(), 2U);
  EXPECT_EQ(scan.curves[1].node_ids, (std::vector<int>{1, 2}));
  std::ofstream(test::scratch_file("two.txt")) << "0\n0\n0\n2\n0 1 0 0 0 0 1\n";
  try {
    read_rawnet(path);
    ADD_FAILURE();
  } catch (const FileError& error) {  // the error names the file of the curve
    EXPECT_EQ(error.path(), test::scratch_file("two.txt"));
    EXPECT_EQ(error.line(), 6);
  }
}

class BadRawnet : public testing::TestWithParam<BadChange> {};

// Each change of the good file above breaks one rule; the sentence names the line and the matter.
TEST_P(BadRawnet, IsRefusedWithLineAndReason) {
  const BadChange& bad = GetParam();
  const std::string text = replaced(kLine, bad.from, bad.to);
  expect_refused([&] { parse_rawnet(text, "bad.rawnet"); }, "bad.rawnet", bad.line, bad.says);
}

INSTANTIATE_TEST_SUITE_P(
    Rawnet, BadRawnet,
    testing::Values(
        BadChange{"Truncated", "+2.5 +1 0 0  0 0 1\n", "", 9, "after 1 of 2 readings"},
        BadChange{"HalfALine", "+2.5 +1 0 0  0 0 1\n", "+2.5 +1 0", 9, "expected 7 numbers"},
        BadChange{"ReadingCountTooSmall", "2\n+0.0", "3\n+0.0", 10, "after 2 of 3 readings"},
        BadChange{"ReadingCountTooLarge", "+2.5 +1 0 0  0 0 1\n", "+1 1 0 0 0 0 1\n+2.5 +1 0 0  0 0 1\n", 10,
                  "number of curves or of readings"},
        BadChange{"CurveCountTooLarge", "1\n0 #", "2\n0 #", 10, "boundary flag of curve 2"},
        BadChange{"NoCurves", "1\n0 # interior\n0\n2\n1 2\n0 1\n2\n+0.0 +1 0 0  0 0 1\n+2.5 +1 0 0  0 0 1\n",
                  "0\n", 1, "no curves"},
        BadChange{"NegativeCurves", "1\n0 #", "-1\n0 #", 1, "number of curves"},
        BadChange{"FlagThree", "0 # interior", "3", 2, "boundary flag"},
        BadChange{"NodeCountMismatch", "2\n1 2\n", "3\n1 2\n", 5, "3 numbers as announced, found 2"},
        BadChange{"NodeIdMissing", "0 1\n2\n", "0\n2\n", 6, "2 numbers as announced, found 1"},
        BadChange{"PositionZero", "1 2\n", "0 1\n", 5, "positions count from 1"},
        BadChange{"PositionBeyond", "1 2\n", "1 3\n", 5, "outside 1 … 2"},
        BadChange{"PositionsFall", "1 2\n", "2 1\n", 5, "must increase"},
        BadChange{"PositionTwice", "1 2\n", "2 2\n", 5, "must increase"},
        BadChange{"NodeNumberGapOfOne", "0 1\n2", "0 2\n2", 6, "node number 2 is out of range"},
        BadChange{"NodeNumberGap", "0 1\n2", "0 7\n2", 6, "node number 7 is out of range"},
        BadChange{"NodeNumberNegative", "0 1\n2", "0 -1\n2", 6, "found \"-1\""},
        BadChange{"OneReading", "2\n+0.0 +1 0 0  0 0 1\n", "1\n", 7, "needs at least 2"},
        BadChange{"HugeCount", "2\n+0.0", "99999999999\n+0.0", 7, "number of readings"},
        BadChange{"NotANumber", "+2.5 +1", "+2.5 nan", 9, "finite"},
        BadChange{"Infinite", "+2.5 +1", "inf +1", 9, "finite"},
        BadChange{"ZeroTangent", "+2.5 +1", "+2.5 0", 9, "tangent of reading 2 of curve 1 has no length"},
        BadChange{"ZeroNormal", "+2.5 +1 0 0  0 0 1", "+2.5 +1 0 0  0 0 0", 9, "normal of reading 2"},
        BadChange{"Parallel", "+2.5 +1 0 0  0 0 1", "+2.5 +1 0 0  -2 0 0", 9, "parallel"},
        BadChange{"DistanceFalls", "+2.5", "-2.5", 9, "distance falls"},
        BadChange{"EightNumbers", "+2.5 +1 0 0  0 0 1", "+2.5 +1 0 0  0 0 1 9", 9, "expected 7 numbers"},
        BadChange{"Letters", "+2.5 +1", "+2.5 x1", 9, "expected 7 numbers"},
        BadChange{"TangentComment", "0 # interior", "# tangents: sideways\n0", 2, "to-next"}),
    [](const auto& bad) { return bad.param.name; });

TEST(Rawnet, RefusesEmptyBinaryAndMissingFiles) {
  EXPECT_THROW(parse_rawnet("", "a"), FileError);
  EXPECT_THROW(parse_rawnet(std::string("\x7f"
                                        "ELF\0\0\1",
                                        7),
                            "a"),
               FileError);
  EXPECT_THROW(read_rawnet(test::scratch_file("missing.rawnet")), FileError);
  EXPECT_THROW(read_rawnet(test::scratch()), FileError);
  EXPECT_THROW(parse_rawnet("0\n1\nother.rawnet\n", "a"), FileError);
}

TEST(Rawnet, RefusesAScanInTwoParts) {
  const std::string block(std::string(kLine).substr(2));
  try {
    parse_rawnet("2\n" + block + replaced(block, "0 1\n2", "2 3\n2"), "parts.rawnet");
    ADD_FAILURE();
  } catch (const FileError& error) {
    EXPECT_NE(std::string(error.what()).find("not connected"), std::string::npos) << error.what();
  }
}

// The time per reading stays the same, so nothing in the parser is quadratic: 200,000 lines take what ten
// times 20,000 take. (No timing here: a quadratic parser would not come back.)
TEST(Rawnet, ReadsLongCurves) {
  constexpr int kReadings = 200000;
  std::string text = "1\n0\n0\n0\n" + std::to_string(kReadings) + "\n";
  for (int i = 0; i < kReadings; ++i) text += std::to_string(i) + " 1 0 0 0 0 1\n";
  EXPECT_EQ(parse_rawnet(std::move(text), "long").curves[0].distances[kReadings - 1], kReadings - 1);
}

TEST(Rawnet, WritesNothingWhereItCannotAndRefusesBrokenScans) {
  const Scan scan = parse_rawnet(kLine, "a");
  EXPECT_THROW(write_rawnet(scan, test::scratch_file("no/such/folder.rawnet")), FileError);
  EXPECT_THROW(write_rawnet(Scan(), test::scratch_file("empty.rawnet")), InvalidInput);
  EXPECT_FALSE(std::filesystem::exists(test::scratch_file("empty.rawnet")));
}

// The public scan of the thesis's author, and simulated ones with 1-based and 0-based comments.
TEST(Rawnet, ReadsThePublicFiles) {
  const std::string data = BATTEN_SHARED_DATA;
  if (!std::filesystem::exists(data)) GTEST_SKIP() << "no public data at " << data;
  const Scan lilium = read_rawnet(data + "/curves/lilium.rawnet");
  ASSERT_EQ(lilium.curves.size(), 3U);  // counts as data/README.md gives them
  EXPECT_EQ(lilium.curves[0].n_readings(), 187);
  EXPECT_EQ(lilium.curves[1].n_readings(), 112);
  EXPECT_EQ(lilium.curves[2].n_readings(), 108);
  EXPECT_TRUE(lilium.curves[0].boundary && lilium.curves[0].closed);
  for (const char* name : {"sphere3", "torus", "bumpycube", "dish", "cone"})
    EXPECT_NO_THROW(read_rawnet(data + "/scans/" + name + ".rawnet")) << name;
}

}  // namespace
}  // namespace batten
