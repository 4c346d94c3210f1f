// Reference device of batten: inertial sensor with its own fusion (BNO085 type, over SPI), measuring wheel with
// a quadrature encoder, two buttons, for ESP32 boards and others of the Arduino kind. README.md beside this
// file has parts, wiring and calibration. The protocol is in batten_protocol.h, which batten's tests compile.
#include <Adafruit_BNO08x.h>
#include <SPI.h>

#include "batten_protocol.h"

using namespace batten_device;

// Wiring: see README.md. Change these to your board.
constexpr int kSensorCs = 5, kSensorInt = 4, kSensorReset = 16;
constexpr int kWheelA = 32, kWheelB = 33;
constexpr int kButtonCurve = 25, kButtonNode = 26;
constexpr int kLed = 2;

// Ticks per metre: roll a measured metre and read it off (README.md).
constexpr Header kHeader = {"batten-reference", "+x,+z", 20000, 100};
constexpr uint32_t kBaud = 230400;  // two lines of some 110 bytes, 100 times a second, need more than 115200
constexpr uint32_t kInterval = 1000000 / 100;

Adafruit_BNO08x sensor(kSensorReset);
Line line;
Commands commands;
Quadrature wheel;
Button curve_button, node_button;
volatile int32_t ticks = 0;
volatile uint32_t stamp_us = 0;
uint32_t seq = 0;
bool sending = false, drawing = false;
float acc[3] = {NAN, NAN, NAN}, gyr[3] = {NAN, NAN, NAN}, mag[3] = {NAN, NAN, NAN};

void IRAM_ATTR wheel_changed() { ticks = ticks + wheel.update(digitalRead(kWheelA), digitalRead(kWheelB)); }
// The time of a sample is when the sensor says that it is ready, not when it has been read.
void IRAM_ATTR sensor_ready() { stamp_us = micros(); }

void send() { Serial.write(line.text(), line.length()); }

void press(const char* key) {
  write_key(line, seq++, micros(), key);
  send();
}

void enable_reports() {
  sensor.enableReport(SH2_ACCELEROMETER, kInterval);
  sensor.enableReport(SH2_GYROSCOPE_CALIBRATED, kInterval);
  sensor.enableReport(SH2_MAGNETIC_FIELD_CALIBRATED, kInterval);
  sensor.enableReport(SH2_ROTATION_VECTOR, kInterval);
}

void setup() {
  Serial.begin(kBaud);
  pinMode(kWheelA, INPUT_PULLUP);
  pinMode(kWheelB, INPUT_PULLUP);
  pinMode(kButtonCurve, INPUT_PULLUP);
  pinMode(kButtonNode, INPUT_PULLUP);
  pinMode(kLed, OUTPUT);
  attachInterrupt(digitalPinToInterrupt(kWheelA), wheel_changed, CHANGE);
  attachInterrupt(digitalPinToInterrupt(kWheelB), wheel_changed, CHANGE);
  attachInterrupt(digitalPinToInterrupt(kSensorInt), sensor_ready, FALLING);
  while (!sensor.begin_SPI(kSensorCs, kSensorInt)) {
    line.begin('E');
    line.put(",the inertial sensor does not answer; check its wires");
    line.finish();
    send();
    delay(1000);
  }
  enable_reports();
}

void obey() {
  while (Serial.available() > 0) {
    switch (commands.take(static_cast<char>(Serial.read()))) {
      case Command::kHeader: write_header(line, kHeader); send(); break;
      case Command::kStart: sending = true; break;
      case Command::kStop: sending = false; break;
      case Command::kLedOff: digitalWrite(kLed, LOW); break;
      case Command::kLedOn: digitalWrite(kLed, HIGH); break;
      case Command::kNone: break;
    }
  }
}

// One button begins and ends curves (held: boundary or inner), the other marks nodes (held: takes one back).
void read_buttons() {
  switch (curve_button.update(!digitalRead(kButtonCurve), micros())) {
    case Button::Press::kShort:
      press(drawing ? "end" : "new");
      drawing = !drawing;
      break;
    case Button::Press::kLong: press("mode"); break;
    case Button::Press::kNone: break;
  }
  switch (node_button.update(!digitalRead(kButtonNode), micros())) {
    case Button::Press::kShort: press("node"); break;
    case Button::Press::kLong: press("undo"); break;
    case Button::Press::kNone: break;
  }
}

void read_sensor() {
  sh2_SensorValue_t value;
  if (sensor.wasReset()) enable_reports();
  while (sensor.getSensorEvent(&value)) {
    const uint32_t t = stamp_us;
    switch (value.sensorId) {
      case SH2_GYROSCOPE_CALIBRATED:
        gyr[0] = value.un.gyroscope.x, gyr[1] = value.un.gyroscope.y, gyr[2] = value.un.gyroscope.z;
        break;
      case SH2_MAGNETIC_FIELD_CALIBRATED:
        mag[0] = value.un.magneticField.x, mag[1] = value.un.magneticField.y, mag[2] = value.un.magneticField.z;
        break;
      case SH2_ACCELEROMETER:
        acc[0] = value.un.accelerometer.x, acc[1] = value.un.accelerometer.y, acc[2] = value.un.accelerometer.z;
        if (sending) write_raw(line, seq++, t, ticks, acc, gyr, mag), send();
        break;
      case SH2_ROTATION_VECTOR: {
        const float q[4] = {value.un.rotationVector.real, value.un.rotationVector.i, value.un.rotationVector.j,
                            value.un.rotationVector.k};
        if (sending) write_fused(line, seq++, t, ticks, q, value.un.rotationVector.accuracy), send();
        break;
      }
    }
  }
}

void loop() {
  obey();
  read_buttons();
  read_sensor();
}
