#include "batten/io/log_columns.hpp"

#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/sensor_log_io.hpp"

namespace batten {
namespace {

TEST(LogColumns, DescriptionsReadBackAsTheyAre) {
  const std::string text =
      "time=t_ms:ms,curve=c,node=n,distance=ticks:0.026mm,acc=ax:ay:az:g,mag=mx:my:mz:uT,gyr=gx:gy:gz:deg/s";
  const LogColumns columns = parse_log_columns(text);
  EXPECT_EQ(format_log_columns(columns), text);
  EXPECT_DOUBLE_EQ(columns[LogQuantity::Time]->factor, 1e-3);
  EXPECT_NEAR(columns[LogQuantity::Distance]->factor, 2.6e-5, 1e-18);
  EXPECT_DOUBLE_EQ(columns[LogQuantity::Accelerometer]->factor, 9.80665);
  EXPECT_DOUBLE_EQ(columns[LogQuantity::Gyroscope]->factor, kPi / 180);
  EXPECT_EQ(columns[LogQuantity::Magnetometer]->names, (std::vector<std::string>{"mx", "my", "mz"}));
  EXPECT_EQ(parse_log_columns("time=t")[LogQuantity::Time]->factor, 1);
}

// Every unit in the one that readings are kept in. A gauss is 1e-4 T, standard gravity 9.80665 m/s2.
TEST(LogColumns, UnitsAreWhatTheyAre) {
  const std::tuple<LogQuantity, const char*, double> kUnits[] = {
      {LogQuantity::Time, "time=t:s", 1},
      {LogQuantity::Time, "time=t:ms", 1e-3},
      {LogQuantity::Time, "time=t:us", 1e-6},
      {LogQuantity::Time, "time=t:ns", 1e-9},
      {LogQuantity::Accelerometer, "time=t,acc=x:y:z:mg", 9.80665e-3},
      {LogQuantity::Magnetometer, "time=t,mag=x:y:z:nT", 1e-3},
      {LogQuantity::Magnetometer, "time=t,mag=x:y:z:mT", 1e3},
      {LogQuantity::Magnetometer, "time=t,mag=x:y:z:T", 1e6},
      {LogQuantity::Magnetometer, "time=t,mag=x:y:z:G", 1e2},
      {LogQuantity::Magnetometer, "time=t,mag=x:y:z:mG", 0.1},
      {LogQuantity::Gyroscope, "time=t,gyr=x:y:z:mdeg/s", kPi / 180e3}};
  for (const auto& [quantity, text, factor] : kUnits)
    EXPECT_DOUBLE_EQ(parse_log_columns(text)[quantity]->factor, factor) << text;
}

TEST(LogColumns, WhatIsWrongIsNamed) {
  const std::pair<const char*, const char*> kTexts[] = {{"", "is no column"},
                                                        {"acc=x:y:z", "need a time"},
                                                        {"time=t:furlong", "no unit of time"},
                                                        {"time=t,acc=x:y", "three"},
                                                        {"time=t,time=u", "twice"},
                                                        {"time=t,speed=v", "speed"},
                                                        {"time=t,curve=c:m", "one column"},
                                                        {"time=", "without a name"},
                                                        {"time=t,acc=x:y:z:deg/s", "no unit of acc"},
                                                        {"time=t,distance=d:0mm", "no unit of distance"},
                                                        {"time=t,distance=d:5%", "no unit of distance"}};
  for (const auto& [text, words] : kTexts) {
    try {
      parse_log_columns(text);
      ADD_FAILURE() << text;
    } catch (const InvalidInput& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  }
}

TEST(GuessedLogColumns, KnowTheNamesOfCommonPrograms) {
  const std::pair<std::vector<std::string>, const char*> kHeaders[] = {
      {{"Time (s)", "Acceleration x (m/s^2)", "Acceleration y (m/s^2)", "Acceleration z (m/s^2)"},
       "time=Time (s):s,acc=Acceleration x (m/s^2):Acceleration y (m/s^2):Acceleration z (m/s^2):m/s2"},
      {{"Time (s)", "Gyroscope X (deg/s)", "Gyroscope Y (deg/s)", "Gyroscope Z (deg/s)",
        "Accelerometer X (g)", "Accelerometer Y (g)", "Accelerometer Z (g)", "Magnetometer X (uT)",
        "Magnetometer Y (uT)", "Magnetometer Z (uT)"},
       "time=Time (s):s,acc=Accelerometer X (g):Accelerometer Y (g):Accelerometer Z (g):g,mag=Magnetometer X "
       "(uT):Magnetometer Y (uT):Magnetometer Z (uT):uT,gyr=Gyroscope X (deg/s):Gyroscope Y "
       "(deg/s):Gyroscope Z "
       "(deg/s):deg/s"},
      {{"Timestamp(ms)", "AccelX", "AccelY", "AccelZ", "GyroX", "GyroY", "GyroZ", "MagX", "MagY", "MagZ",
        "Dist"},
       "time=Timestamp(ms):ms,distance=Dist,acc=AccelX:AccelY:AccelZ,mag=MagX:MagY:MagZ,gyr=GyroX:GyroY:"
       "GyroZ"},
      {{"time", "seconds_elapsed", "accelerometer_z", "accelerometer_y", "accelerometer_x"},
       "time=seconds_elapsed:s,acc=accelerometer_x:accelerometer_y:accelerometer_z"},
      {{"t", "ax", "ay", "az", "gx", "gy", "gz", "mx", "my", "mz", "temperature"},
       "time=t,acc=ax:ay:az,mag=mx:my:mz,gyr=gx:gy:gz"},
      {{"time_s", "acc_x_m_s2", "acc_y_m_s2", "acc_z_m_s2", "node", "curve"},
       "time=time_s:s,curve=curve,node=node,acc=acc_x_m_s2:acc_y_m_s2:acc_z_m_s2:m/s2"},
      // Without gravity, or without one of three axes: not taken.
      {{"Time (s)", "Linear Acceleration x (m/s^2)", "Linear Acceleration y (m/s^2)",
        "Linear Acceleration z (m/s^2)"},
       "time=Time (s):s"},
      {{"time", "accx", "accy"}, "time=time"},
  };
  for (const auto& [names, description] : kHeaders)
    EXPECT_EQ(format_log_columns(guess_log_columns(names)), description);
}

std::string log_in(const std::string& header, double gravity, double step, double field) {
  std::string text = header + "\n";
  for (int i = 0; i < 20; ++i)
    text +=
        std::to_string(i * step) + ",0,0," + std::to_string(gravity) + "," + std::to_string(field) + ",0,0\n";
  return text;
}

// The same motion in other units is the same log.
TEST(GuessedLogColumns, NumbersTellTheirUnits) {
  const std::string header = "t,ax,ay,az,mx,my,mz";
  for (const auto& [gravity, step, field] :
       {std::array{9.81, 0.01, 48.0}, std::array{1.0, 10.0, 48000.0}, std::array{1000.0, 10000.0, 480.0}}) {
    std::vector<std::string> notes;
    const SensorLog log = parse_sensor_log(log_in(header, gravity, step, field), "log", "auto", &notes);
    EXPECT_NEAR(log.time[19], 0.19, 1e-9);
    EXPECT_NEAR(log.accelerometer(3, 2), 9.81, 0.01);
    EXPECT_NEAR(log.magnetometer(3, 0), 48, 1e-6);
    ASSERT_EQ(notes.size(), 2U);
    EXPECT_NE(notes[0].find("time=t:"), std::string::npos) << notes[0];
    EXPECT_NE(notes[1].find("no curves"), std::string::npos) << notes[1];
    // What was guessed, given as a description, reads the same.
    const std::string used =
        notes[0].substr(notes[0].find("time="), notes[0].find(';') - notes[0].find("time="));
    EXPECT_EQ(parse_sensor_log(log_in(header, gravity, step, field), "log", used).accelerometer,
              log.accelerometer);
  }
}

// Few hands turn faster than two turns a second, 4 π rad/s: rates beyond that are degrees.
TEST(GuessedLogColumns, RatesBeyondTwoTurnsASecondAreDegrees) {
  for (const auto& [rate, expected] : {std::pair{30.0, radians(30)}, std::pair{12.0, 12.0}}) {
    std::string text = "t,ax,ay,az,gx,gy,gz\n";
    for (int i = 0; i < 20; ++i) text += concat(0.01 * i, ",0,0,9.81,", i == 7 ? rate : 0.5, ",0,0\n");
    EXPECT_NEAR(parse_sensor_log(text, "log", "auto").gyroscope(7, 0), expected, 1e-12) << rate;
  }
}

TEST(LogOddities, NameTheUnitThatItLooksLike) {
  const std::string own = "time_s,acc_x_m_s2,acc_y_m_s2,acc_z_m_s2,mag_x_uT,mag_y_uT,mag_z_uT";
  std::vector<std::string> notes;
  parse_sensor_log(log_in(own, 9.81, 0.01, 48), "log", {}, &notes);
  EXPECT_TRUE(notes.empty()) << notes[0];
  parse_sensor_log(log_in(own, 1, 10, 48000), "log", {}, &notes);
  ASSERT_EQ(notes.size(), 3U);
  EXPECT_NE(notes[0].find("acc=X:Y:Z:g"), std::string::npos) << notes[0];
  EXPECT_NE(notes[1].find("time=NAME:ms"), std::string::npos) << notes[1];
  EXPECT_NE(notes[2].find("mag=X:Y:Z:nT"), std::string::npos) << notes[2];
  // Half as much again as gravity is no unit: the device is not calibrated.
  notes.clear();
  parse_sensor_log(log_in(own, 14.7, 0.01, 48), "log", {}, &notes);
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_NE(notes[0].find("batten calibrate"), std::string::npos) << notes[0];
}

TEST(DescribedLogs, KnowSeparatorsAndDecimalCommas) {
  const std::string description = "time=t:ms,acc=ax:ay:az:g,distance=d:mm,curve=c";
  const SensorLog comma =
      parse_sensor_log("t,ax,ay,az,d,c\n0,0,0,1,0,1\n10,0,0.5,1,2.5,1\n", "log", description);
  for (const char* text : {"t;ax;ay;az;d;c\n0;0;0;1;0;1\n10;0;0,5;1;2,5;1\n",
                           "\"t\"\t\"ax\"\tay\taz\td\tc\n0\t0\t0\t1\t0\t1\n10\t0\t0,5\t1\t2.5\t1\n"}) {
    const SensorLog log = parse_sensor_log(text, "log", description);
    EXPECT_EQ(log.accelerometer, comma.accelerometer) << text;
    EXPECT_EQ(log.distance, comma.distance);
    EXPECT_EQ(log.curve, comma.curve);
  }
  EXPECT_NEAR(comma.distance[1], 0.0025, 1e-15);
}

TEST(UnknownLogs, AreToldTheirColumnsAndARemedyThatWorks) {
  const std::string text = "Timestamp(ms),AccelX,AccelY,AccelZ\n0,0,0,1\n10,0,0,1\n";
  try {
    parse_sensor_log(text, "log");
    FAIL();
  } catch (const FileError& error) {
    const std::string said = error.what();
    EXPECT_NE(said.find("AccelX"), std::string::npos) << said;
    EXPECT_NE(said.find("time_s"), std::string::npos) << said;
    EXPECT_NE(said.find("--columns auto"), std::string::npos) << said;
  }
  EXPECT_NEAR(parse_sensor_log(text, "log", "auto").accelerometer(1, 2), 9.80665, 1e-9);
  try {
    parse_sensor_log(text, "log", "time=t,acc=AccelX:AccelY:AccelZ:g");
    FAIL();
  } catch (const FileError& error) {
    EXPECT_NE(std::string(error.what()).find("no column \"t\""), std::string::npos) << error.what();
  }
  EXPECT_THROW(parse_sensor_log("colour,size\nred,1\n", "log"), FileError);
  EXPECT_THROW(parse_sensor_log("colour,size\nred,1\n", "log", "auto"), FileError);
}

}  // namespace
}  // namespace batten
