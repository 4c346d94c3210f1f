#include "apps/run_json.hpp"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::test {
namespace {

using Json = nlohmann::json;

// From a simulated pen to a model: a circle drawn in the air is a disc.
TEST(TrackCommand, StrokesOfAPenAreASessionForSketch) {
  run_json(
      "simulate pen -o air.jsonl --truth air.csv --rig-output air-rig.json --path circle --duration 1s "
      "--seed 3");
  const Json json =
      run_json("track air.jsonl --rig air-rig.json -o strokes.jsonl --tip tip.csv --truth air.csv");
  EXPECT_EQ(json["strokes"], 1);
  EXPECT_EQ(json["lost"], 1) << "the first frame, before both cameras have seen the pen";
  EXPECT_LT(json["accuracy"]["lagged"]["mean_mm"], 0.2);
  EXPECT_EQ(json["accuracy"]["wrong_identities"], 0);
  EXPECT_LT(json["accuracy"]["frame_alone"]["rms_by_bound"], 1.15);
  EXPECT_GT(json["accuracy_triangulate"]["lagged"]["mean_mm"], json["accuracy"]["lagged"]["mean_mm"]);
  const std::string tip = read_file("tip.csv");
  EXPECT_EQ(std::count(tip.begin(), tip.end(), '\n'), json["frames"].get<long>() + 1);
  const Json sketch = run_json("sketch strokes.jsonl -o strokes.batten");
  EXPECT_EQ(sketch["curves"], 1);
  EXPECT_EQ(sketch["faces"], 1) << "the circle is closed";
}

TEST(TrackCommand, TheSameBytesForTheSameSeed) {
  run_json("simulate pen -o a.jsonl --rig wiimote --duration 1s --false-blobs 2 --hand 1s --sun --seed 5");
  run_json("simulate pen -o b.jsonl --rig wiimote --duration 1s --false-blobs 2 --hand 1s --sun --seed 5");
  EXPECT_EQ(read_file("a.jsonl"), read_file("b.jsonl"));
  run_json("track a.jsonl --rig wiimote -o a-session.jsonl --tip a.csv --threads 1");
  run_json("track b.jsonl --rig wiimote -o b-session.jsonl --tip b.csv --threads 4");
  EXPECT_EQ(read_file("a.csv"), read_file("b.csv"));
  EXPECT_EQ(read_file("a-session.jsonl"), read_file("b-session.jsonl"));
}

TEST(TrackCommand, SaysWhatIsWrong) {
  write_file(
      "left.jsonl",
      "{\"format\":\"batten blobs\",\"version\":1}\n{\"time\":0,\"camera\":\"left\",\"blobs\":[[1,2]]}\n");
  const auto one = run_batten("track left.jsonl --rig vga -o x.jsonl");
  EXPECT_EQ(one.exit_code, 3);
  EXPECT_NE(one.err.find("no frame of the right camera"), std::string::npos) << one.err;
  EXPECT_FALSE(file_exists("x.jsonl"));
  EXPECT_EQ(run_batten("track left.jsonl --rig none.json -o x.jsonl").exit_code, 3);
  EXPECT_EQ(run_batten("track left.jsonl -o x.jsonl").exit_code, 2) << "blobs without a rig";
  EXPECT_EQ(run_batten("track left.jsonl --rig vga -o x.jsonl --lag -1").exit_code, 2);
  EXPECT_EQ(run_batten("simulate pen -o y.jsonl --hide 5").exit_code, 2);
  EXPECT_EQ(run_batten("simulate pen -o y.jsonl --path nothing.jsonl").exit_code, 3);
}

}  // namespace
}  // namespace batten::test
