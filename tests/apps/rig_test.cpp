#include "apps/run_batten.hpp"
#include "camera/boards.hpp"

#include <filesystem>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "batten/io/rig_io.hpp"

namespace batten::test {
namespace {

using Json = nlohmann::json;

void write_boards(const std::string& name, const BoardScene& scene) {
  write_corners(shown_boards(usual_rig(), scene), scratch() + "/" + name);
}

// Calibrated on some pairs, checked on others: the noise of 0.1 px is all that is left, and both say so.
TEST(RigCommand, CalibratesAndChecks) {
  write_boards("corners.csv", {.pairs = 14, .noise = 0.1});
  write_boards("others.csv", {.pairs = 6, .noise = 0.1, .seed = 9});
  const auto made = run_batten("rig calibrate corners.csv -o rig.json --square 30mm --lens usual --json");
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const Json json = Json::parse(made.out);
  EXPECT_EQ(json["command"], "rig calibrate");
  EXPECT_EQ(json["pairs"], 14);
  EXPECT_EQ(json["lens"], "usual");
  EXPECT_NEAR(json["rms_px"].get<double>(), 0.14, 0.02);  // two coordinates
  EXPECT_NEAR(json["left"]["fx"].get<double>(), 535,
              5 * json["standard_deviations"]["left"]["fx"].get<double>());
  EXPECT_NEAR(json["baseline_m"].get<double>(), usual_rig().baseline(), 0.001);

  const auto checked = run_batten("rig check rig.json others.csv --json");
  ASSERT_EQ(checked.exit_code, 0) << checked.err;
  const Json check = Json::parse(checked.out);
  EXPECT_EQ(check["pairs"], 6);
  EXPECT_LT(check["epipolar_px"].get<double>(), 0.13);
  EXPECT_GE(check["epipolar_rms_px"], check["epipolar_px"]);
  EXPECT_NEAR(check["neighbour_mean"].get<double>(), 1, 0.002);
  EXPECT_LT(check["neighbour_std"].get<double>(), 0.02);
  EXPECT_TRUE(check["warnings"].empty());
  const Json scaled = Json::parse(run_batten("rig check rig.json others.csv --square 15mm --json").out);
  EXPECT_NEAR(scaled["neighbour_mean"].get<double>(), 2, 0.004);
}

TEST(RigCommand, MendsAKnockedRigWithAWand) {
  const StereoRig truth = usual_rig();
  CalibratedRig rig;
  rig.rig = truth;
  rig.rig.rotation = so3_exp(Eigen::Vector3d(0.01, 0.02, -0.01)) * truth.rotation;
  write_rig(rig, scratch() + "/knocked.json");
  std::ostringstream blobs;
  Random random(4);
  for (int k = 0; k < 80; ++k) {
    const double z = random.uniform(0.5, 0.9);
    const Eigen::Vector3d place(random.uniform(-0.15, 0.25) * z, random.uniform(-0.2, 0.2) * z, z);
    const Eigen::Vector3d direction = random.direction();
    for (const bool right : {false, true}) {
      blobs << "{\"time\": " << 0.01 * k << ", \"camera\": \"" << (right ? "right" : "left")
            << "\", \"blobs\": [";
      for (const double light : {0.0, 0.1}) {
        const Eigen::Vector3d left = place + light * direction;
        const Eigen::Vector2d u = right ? project(truth.right, truth.rotation * left + truth.translation)
                                        : project(truth.left, left);
        blobs << (light > 0 ? ", " : "") << "[" << u.x() << ", " << u.y() << "]";
      }
      blobs << "]}\n";
    }
  }
  write_file("blobs.jsonl", blobs.str());
  const auto mended = run_batten("rig wand knocked.json blobs.jsonl -o better.json --length 100mm --json");
  ASSERT_EQ(mended.exit_code, 0) << mended.err;
  const Json json = Json::parse(mended.out);
  EXPECT_GT(json["before"]["epipolar_px"].get<double>(), 3);
  EXPECT_LT(json["after"]["epipolar_px"].get<double>(), 0.05);
  const CalibratedRig better = read_rig(scratch() + "/better.json");
  EXPECT_LT(so3_log(better.rig.rotation * truth.rotation.transpose()).norm(), 1e-4);
  const Json check = Json::parse(run_batten("rig check better.json blobs.jsonl --length 110mm --json").out);
  EXPECT_NEAR(check["length_m"].get<double>(), 0.1, 1e-4);
  ASSERT_EQ(check["warnings"].size(), 1U);
  EXPECT_NE(check["warnings"][0].get<std::string>().find("110 mm"), std::string::npos);
}

TEST(RigCommand, RefusesInWords) {
  write_boards("three.csv", {.pairs = 3});
  const auto few = run_batten("rig calibrate three.csv -o few.json");
  EXPECT_EQ(few.exit_code, 3);
  EXPECT_NE(few.err.find("at least 4 pairs"), std::string::npos) << few.err;
  EXPECT_FALSE(file_exists("few.json"));
  const auto ambiguous = run_batten("rig calibrate three.csv -o rig.json --board 8x6");
  EXPECT_EQ(ambiguous.exit_code, 2);
  EXPECT_NE(ambiguous.err.find("half a turn"), std::string::npos);
  EXPECT_EQ(run_batten("rig calibrate three.csv -o rig.json --square 2%").exit_code, 2);
  write_file("left.png", "");
  EXPECT_NE(run_batten("rig calibrate left.png -o rig.json").err.find("left01.png"), std::string::npos);
  write_file("left1.png", "no image");
  EXPECT_NE(run_batten("rig calibrate left1.png -o rig.json").err.find("no image"), std::string::npos);
  EXPECT_EQ(run_batten("rig").exit_code, 2);
  EXPECT_NE(run_batten("rig chek rig.json x.csv").err.find("did you mean check?"), std::string::npos);
  EXPECT_NE(run_batten("rig check --sqare 2").err.find("--square"), std::string::npos);
}

TEST(RigCommand, CalibratesFromTheSharedImages) {
  const std::string folder = std::string(BATTEN_SHARED_DATA) + "/stereo";
  if (!std::filesystem::exists(folder + "/left01.jpg")) GTEST_SKIP() << folder << " is missing";
  std::string images;
  for (int k = 1; k <= 7; ++k)
    for (const char* side : {"left", "right"})
      images += " '" + folder + "/" + side + "0" + std::to_string(k) + ".jpg'";
  const auto made = run_batten("rig calibrate" + images + " -o images.json --corners found.csv --json");
  if (made.err.find("built without") != std::string::npos) GTEST_SKIP() << made.err;
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const Json json = Json::parse(made.out);
  EXPECT_EQ(json["pairs"], 7);
  EXPECT_EQ(json["corners"].get<int>() + json["left_out"].get<int>(), 756);
  EXPECT_LT(json["epipolar_px"].get<double>(), 0.1);  // 0.162 by the reference, from its own corners
  EXPECT_LT(json["neighbour_std"].get<double>(), 0.0125);
  const Json again = Json::parse(run_batten("rig check images.json found.csv --json").out);
  EXPECT_NEAR(again["epipolar_px"].get<double>(), json["epipolar_px"].get<double>(), 1e-9);
}

}  // namespace
}  // namespace batten::test
