#include <cerrno>
#include <cmath>
#include <cstring>
#include <optional>

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include "batten/capture/byte_stream.hpp"
#include "batten/capture/descriptor_detail.hpp"
#include "batten/core/text.hpp"

namespace batten {

bool detail::wait_for(int descriptor, short events, double seconds, HostClock& clock) {
  pollfd waited{descriptor, events, 0};
  const double real = std::min(seconds * clock.real_seconds(), 60.0);
  const int n = ::poll(&waited, 1, static_cast<int>(std::ceil(real * 1000)));
  return n > 0;
}

namespace {

std::optional<speed_t> speed_of(int baud) {
  switch (baud) {
    case 9600:
      return B9600;
    case 19200:
      return B19200;
    case 38400:
      return B38400;
    case 57600:
      return B57600;
    case 115200:
      return B115200;
    case 230400:
      return B230400;
    case 460800:
      return B460800;
    case 921600:
      return B921600;
    default:
      return std::nullopt;
  }
}

[[noreturn]] void refuse(const std::string& path, int error) {
  const char* const list = "batten capture --list shows what there is";
  if (error == ENOENT || error == ENODEV || error == ENXIO)
    throw InvalidInput(concat(path, ": there is no such port; plug the device in and switch it on, ", list));
  if (error == EACCES || error == EPERM)
    throw InvalidInput(concat(path,
                              ": permission refused; add yourself to its group (sudo usermod -aG dialout "
                              "$USER) and log in anew"));
  if (error == EBUSY || error == EWOULDBLOCK)
    throw InvalidInput(concat(path, ": the port is busy; close the other program that uses it"));
  throw InvalidInput(concat(path, ": cannot be opened: ", std::strerror(error), "; ", list));
}

class SerialPort : public ByteStream {
 public:
  SerialPort(const std::string& path, int baud, HostClock& clock) : path_(path), clock_(clock) {
    const std::optional<speed_t> speed = speed_of(baud);
    if (!speed)
      throw InvalidInput(
          concat("a serial port has no rate of ", baud,
                 " baud; choose one of 9600, 19200, 38400, 57600, 115200, 230400, 460800, 921600"));
    descriptor_ = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (descriptor_ < 0) refuse(path, errno);
    try {
      set_up(*speed);
    } catch (...) {
      ::close(descriptor_);
      throw;
    }
  }
  ~SerialPort() override { ::close(descriptor_); }
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  void write(std::string_view bytes) override {
    while (!bytes.empty()) {
      const ssize_t n = ::write(descriptor_, bytes.data(), bytes.size());
      if (n >= 0) {
        bytes.remove_prefix(static_cast<std::size_t>(n));
      } else if (errno == EAGAIN) {
        if (!detail::wait_for(descriptor_, POLLOUT, 1, clock_))
          throw SourceLost(concat(path_, " takes no bytes"));
      } else if (errno != EINTR) {
        throw SourceLost(concat(path_, " was unplugged"));
      }
    }
  }

  std::string read(double seconds) override {
    char buffer[4096];
    for (int attempt = 0; attempt < 2; ++attempt) {
      const ssize_t n = ::read(descriptor_, buffer, sizeof buffer);
      if (n > 0) return {buffer, static_cast<std::size_t>(n)};
      if (n == 0 || (errno != EAGAIN && errno != EINTR)) throw SourceLost(concat(path_, " was unplugged"));
      if (attempt == 0 && !detail::wait_for(descriptor_, POLLIN, seconds, clock_)) break;
    }
    return {};
  }

 private:
  void set_up(speed_t speed) {
    if (::isatty(descriptor_) == 0)
      throw InvalidInput(concat(path_, ": is no serial port; batten capture --list shows what there is"));
    // Both locks: the first keeps out who asks, the second those who do not.
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) refuse(path_, EBUSY);
    ::ioctl(descriptor_, TIOCEXCL);
    termios settings{};
    if (::tcgetattr(descriptor_, &settings) != 0) refuse(path_, errno);
    ::cfmakeraw(&settings);
    settings.c_cflag |= CLOCAL | CREAD | CS8;
    settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | PARENB | CRTSCTS);
    settings.c_cc[VMIN] = 1;  // so that nothing yet is EAGAIN, and no end of file
    settings.c_cc[VTIME] = 0;
    ::cfsetispeed(&settings, speed);
    ::cfsetospeed(&settings, speed);
    if (::tcsetattr(descriptor_, TCSANOW, &settings) != 0) refuse(path_, errno);
    ::tcflush(descriptor_, TCIOFLUSH);
  }

  std::string path_;
  HostClock& clock_;
  int descriptor_ = -1;
};

}  // namespace

std::unique_ptr<ByteStream> open_serial_port(const std::string& path, int baud, HostClock& clock) {
  return std::make_unique<SerialPort>(path, baud, clock);
}

}  // namespace batten
