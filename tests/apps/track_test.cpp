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

// From images to a track: each frame comes as near to its bound, which is 1.2 times that of the blobs, as
// these know nothing of the noise of room light.
TEST(TrackCommand, FindsThePenInImages) {
  const Json simulated = run_json(
      "simulate pen -o seen.jsonl --images seen --truth seen.csv --rig vga --path line --duration 0.5s "
      "--speed 0.3 --distance 0.8m --false-blobs 2 --seed 3");
  EXPECT_EQ(simulated["images"], simulated["frames"]);
  const Json blobs = run_json("track seen.jsonl --rig vga -o seen-blobs.jsonl --truth seen.csv");
  const Json images = run_json("track seen --rig vga -o seen-images.jsonl --truth seen.csv");
  EXPECT_EQ(images["frames"], simulated["images"]);
  EXPECT_EQ(images["accuracy"]["wrong_identities"], 0);
  EXPECT_LT(images["accuracy"]["frame_alone"]["rms_by_bound"], 1.15);
  EXPECT_LT(images["accuracy"]["frame_alone"]["bound_mm"],
            1.35 * blobs["accuracy"]["frame_alone"]["bound_mm"].get<double>());
  EXPECT_GE(images["accuracy"]["answered_share"], 0.99);
  EXPECT_EQ(read_file("seen-images.jsonl"), [] {
    run_json("track seen --rig vga -o seen-again.jsonl --threads 1");
    return read_file("seen-again.jsonl");
  }());
}

TEST(TrackCommand, RefusesImagesThatAreNone) {
  const std::string list =
      "{\"format\":\"batten "
      "blobs\",\"version\":1}\n{\"time\":0,\"camera\":\"left\",\"image\":\"images/l.pgm\"}\n"
      "{\"time\":0,\"camera\":\"right\",\"image\":\"images/l.pgm\"}\n";
  write_file("images.jsonl", list);
  run_json("simulate pen -o y.jsonl --images images --rig wiimote --path line --duration 0.1s");
  const auto refused = [](const std::string& bytes, const std::string& sentence) {
    write_file("images/l.pgm", bytes);
    const auto run = run_batten("track images.jsonl --rig wiimote -o none.jsonl");
    EXPECT_EQ(run.exit_code, 3) << sentence;
    EXPECT_NE(run.err.find(sentence), std::string::npos) << run.err;
    EXPECT_FALSE(file_exists("none.jsonl"));
  };
  const std::string header = "P5\n128 96\n255\n";
  refused("P5\n64 48\n255\n" + std::string(64 * 48, 9), "128 x 96");
  refused("P6\n128 96\n255\n" + std::string(3 * 128 * 96, 9), "colour");
  refused("P5\n128 96\n65535\n" + std::string(2 * 128 * 96, 9), "8 bits");
  refused(header + std::string(100, 9), "pixels are missing");
  refused("\xff\xd8\xff" + std::string(100, 9), "losses");
  refused(header + std::string(128 * 96, '\xff'), "overexposed");
  refused(header + std::string(128 * 96, '\0'), "black");
  write_file("images/frames.jsonl", list);  // names are relative to the list
  EXPECT_EQ(run_batten("track images --rig wiimote -o none.jsonl").exit_code, 3) << "images that are missing";
  EXPECT_EQ(run_batten("track . --rig wiimote -o none.jsonl").exit_code, 3) << "a folder without a list";
}

}  // namespace
}  // namespace batten::test
