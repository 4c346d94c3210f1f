// The line protocol of batten for a microcontroller: a plain header, without Arduino types, heap or printf of
// floating point. docs/capture.md describes the lines; tests/capture/device_example_test.cpp compiles this
// file on the host and lets it speak with batten's own reader.
#pragma once
#include <stddef.h>
#include <stdint.h>

namespace batten_device {

// A line under construction: 200 characters at most, its check and end included.
class Line {
 public:
  void begin(char kind) {
    length_ = 0;
    put(kind);
  }
  void put(char c) {
    if (length_ < kMost) text_[length_++] = c;
  }
  void put(const char* text) {
    while (*text != '\0') put(*text++);
  }
  void put_unsigned(uint32_t value) {
    char digits[10];
    int n = 0;
    do {
      digits[n++] = static_cast<char>('0' + value % 10);
      value /= 10;
    } while (value > 0);
    while (n > 0) put(digits[--n]);
  }
  void put_signed(int32_t value) {
    if (value < 0) put('-');
    put_unsigned(value < 0 ? 0U - static_cast<uint32_t>(value) : static_cast<uint32_t>(value));
  }
  // With `decimals` digits behind the point, rounded; nothing where it is not measured (NaN) or absurd.
  void put_number(float value, int decimals) {
    const float size = value < 0 ? -value : value;
    if (!(size < 1e6F)) return;
    uint32_t scale = 1;
    for (int i = 0; i < decimals; ++i) scale *= 10;
    const auto whole = static_cast<uint32_t>(size);
    auto part = static_cast<uint32_t>((size - static_cast<float>(whole)) * static_cast<float>(scale) + 0.5F);
    const uint32_t carry = part >= scale ? 1 : 0;
    part -= carry * scale;
    if (value < 0) put('-');
    put_unsigned(whole + carry);
    if (decimals == 0) return;
    put('.');
    for (scale /= 10; scale > 0; scale /= 10) put(static_cast<char>('0' + part / scale % 10));
  }
  // The check *HH (exclusive or of all bytes before it) and the end of the line.
  void finish() {
    uint8_t check = 0;
    for (size_t i = 0; i < length_; ++i) check = static_cast<uint8_t>(check ^ static_cast<uint8_t>(text_[i]));
    text_[length_++] = '*';
    text_[length_++] = hex(check >> 4);
    text_[length_++] = hex(check & 15);
    finish_unchecked();
  }
  // Headers have no check.
  void finish_unchecked() { text_[length_++] = '\n'; }

  const char* text() const { return text_; }
  size_t length() const { return length_; }

 private:
  static constexpr size_t kMost = 195;
  static char hex(int digit) { return static_cast<char>(digit < 10 ? '0' + digit : 'A' + digit - 10); }

  char text_[kMost + 5];
  size_t length_ = 0;
};

struct Header {
  const char* device;   // without blanks
  const char* axes;     // forward and normal of the device, such as "+x,+z"
  uint32_t ticks_per_m;
  uint32_t rate_hz;
};

inline void write_header(Line& line, const Header& header) {
  line.begin('#');
  line.put("batten 1 device=");
  line.put(header.device);
  line.put(" axes=");
  line.put(header.axes);
  line.put(" ticks_per_m=");
  line.put_unsigned(header.ticks_per_m);
  line.put(" rate_hz=");
  line.put_unsigned(header.rate_hz);
  line.put(" quat=wxyz");
  line.finish_unchecked();
}

// m/s², rad/s, µT; a sensor that is not there has NaN.
inline void write_raw(Line& line, uint32_t seq, uint32_t t_us, int32_t ticks, const float acc[3],
                      const float gyr[3], const float mag[3]) {
  line.begin('S');
  line.put(',');
  line.put_unsigned(seq);
  line.put(',');
  line.put_unsigned(t_us);
  line.put(',');
  line.put_signed(ticks);
  for (int k = 0; k < 9; ++k) {
    line.put(',');
    line.put_number(k < 3 ? acc[k] : k < 6 ? gyr[k - 3] : mag[k - 6], k < 3 ? 3 : k < 6 ? 4 : 2);
  }
  line.finish();
}

// The quaternion w x y z takes device axes to a world with z up; accuracy in radians, NaN where not known.
inline void write_fused(Line& line, uint32_t seq, uint32_t t_us, int32_t ticks, const float q[4],
                        float accuracy_rad) {
  line.begin('Q');
  line.put(',');
  line.put_unsigned(seq);
  line.put(',');
  line.put_unsigned(t_us);
  line.put(',');
  line.put_signed(ticks);
  for (int k = 0; k < 4; ++k) {
    line.put(',');
    line.put_number(q[k], 5);
  }
  line.put(',');
  line.put_number(accuracy_rad, 3);
  line.finish();
}

// "new", "node", "end", "undo", "mode".
inline void write_key(Line& line, uint32_t seq, uint32_t t_us, const char* key) {
  line.begin('K');
  line.put(',');
  line.put_unsigned(seq);
  line.put(',');
  line.put_unsigned(t_us);
  line.put(',');
  line.put(key);
  line.finish();
}

// What the host sends: lines "?", "start", "stop", "led 0", "led 1".
enum class Command { kNone, kHeader, kStart, kStop, kLedOff, kLedOn };

class Commands {
 public:
  Command take(char c) {
    if (c != '\n') {
      if (c != '\r' && length_ < sizeof text_ - 1) text_[length_++] = c;
      return Command::kNone;
    }
    text_[length_] = '\0';
    length_ = 0;
    if (is("?")) return Command::kHeader;
    if (is("start")) return Command::kStart;
    if (is("stop")) return Command::kStop;
    if (is("led 0")) return Command::kLedOff;
    if (is("led 1")) return Command::kLedOn;
    return Command::kNone;
  }

 private:
  bool is(const char* word) const {
    size_t i = 0;
    while (word[i] != '\0' && text_[i] == word[i]) ++i;
    return word[i] == text_[i];
  }

  char text_[16] = {};
  size_t length_ = 0;
};

// A quadrature encoder: both lines are read at every change of either.
class Quadrature {
 public:
  // Steps by which the wheel has turned since the last call; 0 where a change was missed.
  int update(bool a, bool b) {
    static constexpr int8_t kSteps[16] = {0, 1, -1, 0, -1, 0, 0, 1, 1, 0, 0, -1, 0, -1, 1, 0};
    const int state = (b ? 2 : 0) + (a ? 1 : 0);
    const int step = kSteps[4 * last_ + state];
    last_ = state;
    return step;
  }

 private:
  int last_ = 0;
};

// A button that bounces: pressed once when it has been down for 20 ms, again only after it was up as long. A
// press of more than 0.7 s is a long one, told when the button goes up.
class Button {
 public:
  enum class Press { kNone, kShort, kLong };

  Press update(bool down, uint32_t t_us) {
    if (down != raw_) {
      raw_ = down;
      since_us_ = t_us;
    }
    if (t_us - since_us_ < 20000 || raw_ == down_) return Press::kNone;
    down_ = raw_;
    if (down_) {
      pressed_us_ = since_us_;
      return Press::kNone;
    }
    return since_us_ - pressed_us_ > 700000 ? Press::kLong : Press::kShort;
  }

 private:
  bool raw_ = false, down_ = false;
  uint32_t since_us_ = 0, pressed_us_ = 0;
};

}  // namespace batten_device
