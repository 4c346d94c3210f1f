#include "run_batten.hpp"

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::test {
namespace {

using Json = nlohmann::json;

// From the simulated hand to the surface by the command line alone.
TEST(Capture, ASimulatedDeviceBecomesASurfaceNearTheTruth) {
  const auto run = run_batten(
      "capture \"simulator:sphere?speed=max&tumble=1&flip=1%&seed=8\" -o s.blog --wheel 62.8mm --overwrite "
      "--json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json json = Json::parse(run.out);
  EXPECT_EQ(json["curves"], 3);
  EXPECT_EQ(json["losses"], 0);
  EXPECT_EQ(json["decoded"]["form"], "be-sm");
  ASSERT_EQ(run_batten("convert s.blog s.rawnet").exit_code, 0);
  ASSERT_EQ(run_batten("simulate sphere -o exact.rawnet --truth-network truth.net --step 2%").exit_code, 0);
  ASSERT_EQ(run_batten("network s.rawnet -o s.json").exit_code, 0);
  const auto compared = run_batten("compare s.json truth.net --register similarity --json");
  ASSERT_EQ(compared.exit_code, 0) << compared.err;
  EXPECT_LT(Json::parse(compared.out)["relative"]["a_to_b"]["mean"].get<double>(), 0.005);
}

TEST(Capture, TheTumbleOfARecordingCalibratesTheDevice) {
  ASSERT_EQ(
      run_batten(
          "capture \"simulator:sphere?speed=max&tumble=1&distortion=1&device=line&rate=50&seed=3\" -o t.blog "
          "--overwrite --seconds 64")
          .exit_code,
      0);
  ASSERT_EQ(run_batten("convert t.blog t.csv").exit_code, 0);
  const auto run = run_batten("calibrate t.csv -o t.json --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_LT(Json::parse(run.out)["magnetometer"]["rms_residual"].get<double>(), 0.02);
  EXPECT_EQ(
      run_batten(
          "capture \"simulator:sphere?speed=max\" -o u.blog --overwrite --calibration t.json --seconds 3")
          .exit_code,
      0);
  EXPECT_NE(read_file("u.blog").find("#calibration {"), std::string::npos);
}

TEST(Capture, ReplayTellsTheSame) {
  ASSERT_EQ(run_batten("capture \"simulator:dish?speed=max&pace=60\" -o r.blog --overwrite").exit_code, 0);
  const auto replay = run_batten("replay r.blog --speed 0 --json");
  ASSERT_EQ(replay.exit_code, 0) << replay.err;
  ASSERT_EQ(run_batten("capture file:r.blog?x -o r2.blog").exit_code, 3);  // no such file
  const Json json = Json::parse(replay.out);
  EXPECT_EQ(json["end"], "the recording is over");
  EXPECT_GT(json["decoded"]["readings"], 1000);
  ASSERT_EQ(run_batten("convert r.blog r.csv").exit_code, 0);
}

TEST(Capture, KeysComeFromAPipe) {
  write_file("keys.txt", "+0\n.+1\n.");
  ASSERT_EQ(run_batten("capture simulator:sphere?speed=max -o k.blog --overwrite --seconds 1 < " + scratch() +
                       "/keys.txt")
                .exit_code,
            0);
  const std::string recording = read_file("k.blog");
  EXPECT_NE(recording.find(",keys,key,enter"), std::string::npos);
  EXPECT_NE(recording.find(",keys,key,."), std::string::npos);
}

TEST(Capture, RefusesInWords) {
  const auto expect = [](const std::string& arguments, int code, const std::string& word) {
    const auto run = run_batten(arguments);
    EXPECT_EQ(run.exit_code, code) << arguments << run.err;
    EXPECT_NE(run.err.find(word), std::string::npos) << run.err;
  };
  expect("capture", 2, "--list");
  expect("capture simulator:sphere", 2, "--output");
  expect("capture serial:x -o x.blog", 2, "no source");
  expect("capture line:/dev/no-such-port -o x1.blog", 3, "plug the device in");
  expect("capture line:/dev/null -o x2.blog", 3, "no serial port");
  expect("capture simulator:sphere -o /dev/full", 3, "disk is full");
  expect("capture simulator:sphere?speed=max -o x.blog --wheel 5%", 2, "wheel");
  write_file("old.blog", "#batten-recording 9\n");
  expect("convert old.blog x.rawnet", 3, "newer");
  expect("replay old.blog", 3, "newer");
  expect("capture simulator:sphere?speed=max -o old.blog", 3, "exists");
  write_file("empty.blog", "#batten-recording 1\n#events x\n");
  expect("convert empty.blog x.rawnet", 3, "no readings");
  expect("convert empty.blog x.ply", 3, ".rawnet");
  const auto list = run_batten("capture --list");
  EXPECT_EQ(list.exit_code, 0);
  EXPECT_NE(list.out.find("simulator:torus"), std::string::npos);
}

}  // namespace
}  // namespace batten::test
