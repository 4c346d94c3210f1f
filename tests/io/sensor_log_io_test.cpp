#include "batten/io/sensor_log_io.hpp"

#include "io/bad_files.hpp"
#include "scratch.hpp"

#include <cmath>
#include <fstream>

#include <gtest/gtest.h>

#include "batten/io/file.hpp"
#include "batten/io/scan_io.hpp"

namespace batten {
namespace {

using namespace test;

const char* const kLog =
    "# anything\n"
    "# axes: forward=-y normal=+z\n"
    "# curve 3: boundary closed name=the rim\n"
    "time_s,curve,node,distance_m,acc_x_m_s2,acc_y_m_s2,acc_z_m_s2,mag_x_uT,mag_y_uT,mag_z_uT,gyr_x_rad_s,"
    "gyr_y_rad_s,gyr_z_rad_s\n"
    "0,,,,0,0,9.81,20,1,-40,,,\n"
    "0.5,3,0,0,0,0,9.81,20,1,-40,0.01,0,0\n"
    "1,3,,0.1,0,0.1,9.80,20,2,-40,0.02,0,nan\n"
    "1.5,3,1,0.2,0,0.2,9.79,20,3,-40,0.03,0,0\n";

TEST(SensorLogFile, ReadsColumnsFlagsAndAxes) {
  const SensorLog log = parse_sensor_log(kLog, "log.csv");
  ASSERT_EQ(log.n_readings(), 4);
  EXPECT_EQ(log.axes.forward, Eigen::Vector3d(0, -1, 0));
  ASSERT_EQ(log.curves.size(), 1U);
  EXPECT_EQ(log.curves[0].number, 3);
  EXPECT_TRUE(log.curves[0].boundary && log.curves[0].closed);
  EXPECT_EQ(log.curves[0].name, "the rim");
  EXPECT_EQ(log.curve, (std::vector<int>{SensorLog::kNone, 0, 0, 0}));
  EXPECT_EQ(log.node, (std::vector<int>{SensorLog::kNone, 0, SensorLog::kNone, 1}));
  EXPECT_TRUE(std::isnan(log.distance[0]));
  EXPECT_EQ(log.distance[3], 0.2);
  EXPECT_EQ(log.magnetometer(2, 1), 2);
  EXPECT_TRUE(std::isnan(log.gyroscope(0, 0)));
  EXPECT_TRUE(std::isnan(log.gyroscope(2, 2)));
}

TEST(SensorLogFile, ASharpCurveIsReadAndWritten) {
  const SensorLog log = parse_sensor_log(replaced(kLog, "boundary closed", "sharp closed"), "log.csv");
  EXPECT_TRUE(log.curves[0].sharp && log.curves[0].closed && !log.curves[0].boundary);
  const std::string path = test::scratch_file("sharp.csv");
  write_sensor_log(log, path);
  EXPECT_TRUE(read_sensor_log(path).curves[0].sharp);
}

TEST(SensorLogFile, TakesColumnsInAnyOrderAndIgnoresOthers) {
  const SensorLog log = parse_sensor_log("\"mag_x_uT\",remark,time_s\r\n7,\"hello\",1\r\n8,,2\r\n", "a");
  EXPECT_EQ(log.magnetometer(1, 0), 8);
  EXPECT_EQ(log.time[1], 2);
  EXPECT_TRUE(std::isnan(log.accelerometer(0, 0)));
}

TEST(SensorLogFile, WritingAndReadingLosesNothing) {
  const SensorLog log = parse_sensor_log(kLog, "log.csv");
  const std::string path = test::scratch_file("round.csv");
  write_sensor_log(log, path);
  const SensorLog back = read_sensor_log(path);
  const std::string again = test::scratch_file("again.csv");
  write_sensor_log(back, again);
  EXPECT_EQ(read_file(path), read_file(again));
  EXPECT_EQ(back.time, log.time);
  EXPECT_EQ(back.accelerometer, log.accelerometer);
  EXPECT_EQ(back.curve, log.curve);
  EXPECT_EQ(back.node, log.node);
  EXPECT_EQ(back.curves[0].name, log.curves[0].name);
  EXPECT_EQ(back.axes.forward, log.axes.forward);
}

class BadSensorLog : public testing::TestWithParam<BadChange> {};

TEST_P(BadSensorLog, IsRefusedWithLineAndReason) {
  const BadChange& bad = GetParam();
  const std::string text = replaced(kLog, bad.from, bad.to);
  expect_refused([&] { parse_sensor_log(text, "bad.csv"); }, "bad.csv", bad.line, bad.says);
}

INSTANTIATE_TEST_SUITE_P(
    SensorLogFile, BadSensorLog,
    testing::Values(BadChange{"NoHeader", "time_s,curve,node", "1,2,3", 4, "names of the columns"},
                    BadChange{"ColumnTwice", "time_s,curve", "time_s,time_s", 4, "named twice"},
                    BadChange{"CellMissing", "0.5,3,0,0,", "0.5,3,0,", 6, "expected 13 cells"},
                    BadChange{"CellTooMany", "0.5,3,0,0,", "0.5,3,0,0,0,", 6, "found 14"},
                    BadChange{"NotANumber", "0.5,3", "x,3", 6, "expected a number for time_s"},
                    BadChange{"Infinite", "1,3,,0.1,0", "1,3,,0.1,inf", 7, "acc_x_m_s2"},
                    BadChange{"NoTime", "0.5,3", ",3", 6, "no time"},
                    BadChange{"FractionalCurve", "0.5,3,0", "0.5,3.5,0", 6, "whole number"},
                    BadChange{"NegativeNode", "0.5,3,0", "0.5,3,-1", 6, "whole number"},
                    BadChange{"NodeWithoutCurve", "0.5,3,0", "0.5,,0", 6, "a node needs a curve"},
                    BadChange{"TimeFalls", "1,3,,", "0.4,3,,", 7, "time falls"},
                    BadChange{"DistanceFalls", "1.5,3,1,0.2", "1.5,3,1,0.05", 8, "distance falls"},
                    BadChange{"NodeGap", "1.5,3,1", "1.5,3,9", 8, "out of range"},
                    BadChange{"CurveResumed", "1,3,,0.1", "1,4,,0.1", 8, "taken up again"},
                    BadChange{"UnknownFlag", "boundary closed", "boundary round", 3, "found \"round\""},
                    BadChange{"UnknownAxis", "forward=-y", "forward=w", 2, "device axes"},
                    BadChange{"ParallelAxes", "forward=-y", "forward=-z", 2, "right angles"}),
    [](const auto& bad) { return bad.param.name; });

TEST(SensorLogFile, RefusesFilesWithoutReadings) {
  EXPECT_THROW(parse_sensor_log("", "a"), FileError);
  EXPECT_THROW(parse_sensor_log("time_s,curve\n", "a"), FileError);
  EXPECT_THROW(read_sensor_log(test::scratch_file("missing.csv")), FileError);
}

TEST(SensorLogFile, IsReadAsAScanWhateverItsName) {
  const std::string path = test::scratch_file("log.rawnet");
  std::ofstream(path) << replaced(kLog, " closed", "");
  const LogScan result = read_scan(path);
  EXPECT_EQ(result.scan.curves[0].n_readings(), 3);
  EXPECT_EQ(result.scan.curves[0].node_readings, (std::vector<int>{0, 2}));
}

TEST(CalibrationFile, WritingAndReadingLosesNothing) {
  DeviceCalibration device;
  device.calibration.accelerometer.offset = {0.1, -1.0 / 3, 2e-7};
  device.calibration.magnetometer.matrix << 1.1, 0.01, 0, 0.02, 0.9, 0, 0, 0.03, 1.0 / 7;
  device.calibration.gyroscope_bias = {0.01, 0.02, -0.03};
  const std::string path = test::scratch_file("calibration.json");
  write_calibration(device, path);
  const Calibration back = read_calibration(path);
  EXPECT_EQ(back.accelerometer.offset, device.calibration.accelerometer.offset);
  EXPECT_EQ(back.accelerometer.matrix, device.calibration.accelerometer.matrix);
  EXPECT_EQ(back.magnetometer.matrix, device.calibration.magnetometer.matrix);
  EXPECT_EQ(back.gyroscope_bias, device.calibration.gyroscope_bias);
}

TEST(CalibrationFile, NamesTheEntryThatIsWrong) {
  DeviceCalibration device;
  const std::string path = test::scratch_file("bad.json");
  write_calibration(device, path);
  const std::string good = read_file(path);
  const auto complaint = [](const std::string& text) {
    try {
      parse_calibration(text, "bad.json");
    } catch (const FileError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_NE(complaint("{").find("not valid JSON"), std::string::npos);
  EXPECT_NE(complaint("[]").find("no calibration"), std::string::npos);
  EXPECT_NE(complaint(replaced(good, "\"magnetometer\"", "\"compass\"")).find("magnetometer is missing"),
            std::string::npos);
  EXPECT_NE(complaint(replaced(good, "\"offset\"", "\"zero\"")).find("accelerometer.offset is missing"),
            std::string::npos);
  EXPECT_NE(complaint(replaced(good, "1.0", "\"one\"")).find("accelerometer."), std::string::npos);
  EXPECT_EQ(complaint(good), "accepted");
  // One axis ten million times weaker than the others measures nothing, though its inverse exists.
  device.calibration.magnetometer.matrix(2, 2) = 1e-7;
  write_calibration(device, path);
  EXPECT_NE(complaint(read_file(path)).find("magnetometer.matrix is singular"), std::string::npos);
}

}  // namespace
}  // namespace batten
