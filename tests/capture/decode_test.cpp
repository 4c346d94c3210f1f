#include "batten/capture/decode.hpp"

#include "capture/simulated.hpp"

#include <cmath>
#include <string>

#include <Eigen/QR>
#include <gtest/gtest.h>

#include "batten/capture/line_protocol.hpp"
#include "batten/core/error.hpp"
#include "batten/pipeline/reconstruction.hpp"
#include "batten/simulation/shapes.hpp"

namespace batten::test {
namespace {

// The truth of a simulated sphere of 0.3 m: its curves, their lengths and their nodes.
void expect_sphere(const DecodedRecording& decoded, double tolerance) {
  const TracedNetwork truth = trace_shape(AnalyticShape::Sphere);
  const double scale = 0.3 / truth.diameter;
  ASSERT_EQ(decoded.log.curves.size(), truth.curves.size());
  const LogScan scan = scan_from_recording(decoded);
  for (std::size_t c = 0; c < truth.curves.size(); ++c) {
    const ScanCurve& curve = scan.scan.curves[c];
    EXPECT_EQ(curve.closed, truth.curves[c].closed);
    EXPECT_EQ(curve.boundary, truth.curves[c].boundary);
    ASSERT_EQ(curve.node_ids, truth.curves[c].node_ids) << "curve " << c + 1;
    EXPECT_NEAR(curve.distances[curve.n_readings() - 1], scale * truth.curves[c].path->length(), tolerance);
    for (std::size_t k = 0; k < curve.node_ids.size(); ++k)
      EXPECT_NEAR(curve.distances[curve.node_readings[k]], scale * truth.curves[c].node_distances[k],
                  tolerance);
  }
}

// A turn of the wheel has 500 ticks, so that a length between two readings is off by two ticks at most.
constexpr double kTwoTicks = 2 * 0.0628 / 500 + 1e-9;

TEST(DecodeRecording, FindsCurvesNodesAndLengthsOfAMorphorider) {
  const Captured captured_sphere = captured("simulator:sphere?speed=max&noise=0&rest=0.8&pace=20");
  const DecodedRecording decoded = decode_recording(captured_sphere.recording);
  expect_sphere(decoded, kTwoTicks);
  EXPECT_LT(decoded.report.n_refused, 0.05 * static_cast<double>(decoded.report.n_packets));
  ASSERT_TRUE(decoded.report.form.has_value());
  EXPECT_TRUE(decoded.report.form->settled);
  EXPECT_EQ(decoded.report.form->form, PacketForm::BigSignMagnitude);
}

TEST(DecodeRecording, FindsThemThroughBurstsDriftingClocksAndWraps) {
  // The clock of the simulated device wraps in the first second.
  const Captured run = captured(
      "simulator:sphere?speed=max&noise=0&rest=0.8&pace=20&device=line&burst=0.02&ppm=400&duplicate=5%");
  const DecodedRecording decoded = decode_recording(run.recording);
  expect_sphere(decoded, kTwoTicks);
  EXPECT_NEAR(decoded.report.clock_rate, 1 / (1 + 400e-6), 5e-5);
  EXPECT_GT(decoded.report.n_duplicates, 10);
  EXPECT_EQ(decoded.report.n_missing, 0);
  EXPECT_EQ(decoded.report.n_clock_jumps, 0);
}

TEST(DecodeRecording, FindsThemInAStreamWithWrongBytes) {
  const Captured run = captured("simulator:sphere?speed=max&pace=20&flip=1%&tumble=1&seed=6");
  const DecodedRecording decoded = decode_recording(run.recording);
  expect_sphere(decoded, 2 * kTwoTicks);
  EXPECT_GT(decoded.report.n_refused, 0);
}

TEST(DecodeRecording, IsAFunctionOfTheRecording) {
  const Captured run = captured("simulator:sphere?speed=max&pace=20", {.seconds = 20});
  const Recording read = parse_recording(text_of(run.recording), "x.blog");
  EXPECT_EQ(read.events, run.recording.events);
  const DecodedRecording a = decode_recording(run.recording), b = decode_recording(read);
  EXPECT_EQ(a.log.time, b.log.time);
  EXPECT_EQ(a.log.accelerometer, b.log.accelerometer);
  EXPECT_EQ(a.log.node, b.log.node);
}

TEST(DecodeRecording, LeavesOutACurveWhoseLengthsWereLost) {
  const Captured run = captured("simulator:sphere?speed=max&pace=10&reboot=12");
  const DecodedRecording decoded = decode_recording(run.recording);
  EXPECT_EQ(decoded.log.curves.size(), 2U);
  bool told = false;
  for (const std::string& warning : decoded.warnings)
    told = told || warning.find("draw it again") != std::string::npos;
  EXPECT_TRUE(told);
}

/// A recording of a device of the line protocol that moves 1 mm every 10 ms, with keys.
Recording rolling(const std::vector<std::pair<double, std::string>>& keys, double seconds = 10) {
  Recording recording;
  std::string header = "#batten 1 device=test axes=+x,+z ticks_per_m=1000";
  recording.events.push_back({0, "device", EventKind::Line, header});
  for (int i = 0; i < 100 * seconds; ++i) {
    RawSample sample;
    sample.seq = static_cast<std::uint32_t>(i);
    sample.t_us = static_cast<std::uint32_t>(10000 * i);
    // It stands still in every second second.
    sample.ticks = i / 100 % 2 == 0 ? i / 200 * 100 + i % 100 : i / 200 * 100 + 100;
    sample.accelerometer = {0, 0, 9.81};
    sample.gyroscope.setZero();
    sample.magnetometer = {24, 0, -41};
    recording.events.push_back({10000 * i, "device", EventKind::Line, format_line(sample)});
  }
  for (const auto& [time, key] : keys)
    recording.events.push_back({std::llround(time * 1e6), "keys", EventKind::Key, key});
  return recording;
}

TEST(DecodeRecording, ANodeIsTheStayAroundItsKey) {
  const DecodedRecording decoded =
      decode_recording(rolling({{0.005, "-"}, {1.5, "1"}, {1.6, "enter"}, {3.1, "2"}, {3.2, "."}}));
  ASSERT_EQ(decoded.log.curves.size(), 1U);
  EXPECT_TRUE(decoded.log.curves[0].boundary);
  for (Eigen::Index i = 0; i < decoded.log.n_readings(); ++i) {
    const double t = decoded.log.time[i];
    const int node = decoded.log.node[static_cast<std::size_t>(i)];
    // 0.3 s to both sides, but not before it stood, at 3.0 s, and not after the curve.
    if (t > 1.2001 && t < 1.7999) {
      EXPECT_EQ(node, 1) << t;
    } else if (t > 3.0001 && t < 3.1999) {
      EXPECT_EQ(node, 2) << t;
    } else if (t < 1.19 || (t > 1.81 && t < 2.99) || t > 3.21) {
      EXPECT_EQ(node, SensorLog::kNone) << t;
    }
  }
  EXPECT_NEAR(decoded.log.distance[319] - decoded.log.distance[1], 0.199, 1e-9);
}

TEST(DecodeRecording, DistancesOfAPauseDoNotCount) {
  const DecodedRecording decoded =
      decode_recording(rolling({{0.005, "+"}, {1.5, "*"}, {3.5, "*"}, {5.5, "."}}));
  ASSERT_EQ(decoded.log.curves.size(), 1U);
  EXPECT_EQ(decoded.log.curve[250], SensorLog::kNone);
  EXPECT_EQ(decoded.log.curve[450], 0);
  EXPECT_NEAR(decoded.log.distance[540] - decoded.log.distance[1], 0.299 - 0.1, 1e-9);
}

TEST(DecodeRecording, NodesWithoutNumbersGetTheirOwnAndGapsAreClosed) {
  Recording recording = rolling({{0.005, "+"}, {1.5, "3"}, {1.6, "enter"}, {5.5, "."}});
  ButtonPress press;
  press.t_us = 3500000;
  press.key = "node";
  recording.events.push_back({3501000, "device", EventKind::Line, format_line(press)});
  const DecodedRecording decoded = decode_recording(recording);
  EXPECT_EQ(decoded.log.node[150], 1);
  EXPECT_EQ(decoded.log.node[350], 2);
  EXPECT_EQ(decoded.warnings.size(), 2U);
}

TEST(DecodeRecording, SaysWhatIsMissing) {
  EXPECT_THROW(decode_recording({}), InvalidInput);
  DecodeOptions options;
  options.wheel_m = -1;
  EXPECT_THROW(decode_recording(rolling({}), options), InvalidInput);
  const DecodedRecording decoded = decode_recording(rolling({}));
  EXPECT_EQ(decoded.log.n_readings(), 1000);  // kept, though on no curve
  try {
    scan_from_recording(decoded);
    ADD_FAILURE();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("press +"), std::string::npos);
  }
}

// 90 degrees about z take forward to the left; the device of the recording says so by its quaternion.
TEST(ScanFromRecording, TakesTheOrientationsOfTheDevice) {
  Recording recording = rolling({{0.005, "+"}, {1.5, "."}});
  for (int i = 0; i < 1000; ++i) {
    FusedSample fused;
    fused.seq = static_cast<std::uint32_t>(i);
    fused.t_us = static_cast<std::uint32_t>(10000 * i);
    fused.orientation = Eigen::Quaterniond(std::sqrt(0.5), 0, 0, std::sqrt(0.5));
    recording.events.push_back({10000 * i, "device", EventKind::Line, format_line(fused)});
  }
  const LogScan scan = scan_from_recording(decode_recording(recording));
  EXPECT_NEAR((scan.scan.curves[0].tangents.row(5) - Eigen::RowVector3d(0, 1, 0)).norm(), 0, 1e-5);
  EXPECT_NEAR((scan.scan.curves[0].normals.row(5) - Eigen::RowVector3d(0, 0, 1)).norm(), 0, 1e-5);
  const LogScan raw = scan_from_recording(decode_recording(recording), Calibration{});
  EXPECT_NEAR((raw.scan.curves[0].tangents.row(5) - Eigen::RowVector3d(1, 0, 0)).norm(), 0, 1e-5);
}

// From the hand to the surface: a sphere of diameter 0.3 m, whose bounding box has that diagonal.
TEST(ScanFromRecording, ReconstructsToTheSurface) {
  for (const char* device : {"morphorider&tumble=1&flip=1%", "line"}) {
    const Captured run = captured(std::string("simulator:sphere6?speed=max&seed=21&device=") + device);
    const Reconstruction result = reconstruct(scan_from_recording(decode_recording(run.recording)).scan);
    const Points& X = result.surface.mesh.positions;
    // The sphere nearest to the vertices: |x|² = 2 c·x + (R² − |c|²).
    Eigen::MatrixXd A(X.rows(), 4);
    A << 2 * X, Eigen::VectorXd::Ones(X.rows());
    const Eigen::Vector4d u = A.colPivHouseholderQr().solve(Eigen::VectorXd(X.rowwise().squaredNorm()));
    const Eigen::RowVector3d centre = u.head<3>().transpose();
    const double radius = 0.3 / (2 * std::sqrt(3.0));
    const Eigen::VectorXd off = (X.rowwise() - centre).rowwise().norm().array() - radius;
    EXPECT_LT(off.cwiseAbs().mean(), 0.005 * 0.3) << device;
  }
}

}  // namespace
}  // namespace batten::test
