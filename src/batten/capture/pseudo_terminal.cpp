#include "batten/capture/pseudo_terminal.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include "batten/core/text.hpp"

namespace batten {

namespace {

constexpr double kTurn = 0.001;  // seconds of the clock between two looks at the device

class DirectStream : public ByteStream {
 public:
  DirectStream(SimulatedDevice& device, VirtualClock& clock) : device_(device), clock_(clock) {
    if (!device.plugged(clock.now_us()))
      throw InvalidInput("the simulated device is unplugged; wait until it comes back");
    device.transmit(clock.now_us());  // what came before the port was opened is not there
  }

  void write(std::string_view bytes) override {
    check_plug();
    device_.receive(bytes, clock_.now_us());
  }

  std::string read(double seconds) override {
    const std::int64_t deadline = clock_.now_us() + std::max<std::int64_t>(0, std::llround(seconds * 1e6));
    for (;;) {
      check_plug();
      const std::int64_t now = clock_.now_us();
      std::string bytes = device_.transmit(now);
      if (!bytes.empty() || now >= deadline) return bytes;
      const std::int64_t next = std::min(deadline, device_.next_transmission_us(now));
      clock_.wait(static_cast<double>(next - now) * 1e-6);
    }
  }

 private:
  void check_plug() const {
    if (!device_.plugged(clock_.now_us())) throw SourceLost("the simulated device was unplugged");
  }

  SimulatedDevice& device_;
  VirtualClock& clock_;
};

}  // namespace

struct PseudoTerminal::Implementation {
  Implementation(SimulatedDevice simulated, HostClock& host_clock)
      : device(std::move(simulated)), clock(host_clock) {
    std::string pattern = (std::filesystem::temp_directory_path() / "batten-device-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr)
      throw InvalidInput(concat("no folder for a simulated port can be made in ",
                                std::filesystem::temp_directory_path().string()));
    folder = pattern;
    path = folder + "/tty";
    try {
      plug_in();
    } catch (...) {
      std::filesystem::remove_all(folder);
      throw;
    }
    server = std::thread([this] { serve(); });
  }

  ~Implementation() {
    stop = true;
    server.join();
    unplug();
    std::error_code none;
    std::filesystem::remove_all(folder, none);
  }

  void plug_in() {
    master = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    const char* name = nullptr;
    if (master >= 0 && ::grantpt(master) == 0 && ::unlockpt(master) == 0) name = ::ptsname(master);
    if (name == nullptr) {
      if (master >= 0) ::close(master);
      master = -1;
      throw InvalidInput("the system has no pseudo-terminal for a simulated port");
    }
    // Renamed into place: whoever looks sees the old port, none, or the new one.
    std::error_code none;
    std::filesystem::remove(path + ".next", none);
    std::filesystem::create_symlink(name, path + ".next");
    std::filesystem::rename(path + ".next", path);
  }

  void unplug() {
    std::error_code none;
    std::filesystem::remove(path, none);
    if (master >= 0) ::close(master);
    master = -1;
  }

  void serve() {
    while (!stop) {
      const std::int64_t now = clock.now_us();
      {
        const std::lock_guard lock(mutex);
        serve_once(now);
      }
      pollfd waited{master, POLLIN, 0};
      const double real_ms = 1000 * kTurn * clock.real_seconds();
      // A master without a program at the other end is "hung up" at once: then time must pass otherwise.
      if (master < 0 || ::poll(&waited, 1, std::max(1, static_cast<int>(real_ms))) <= 0 ||
          (waited.revents & POLLHUP) != 0)
        std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
  }

  void serve_once(std::int64_t now) {
    if (!device.plugged(now)) {
      if (master >= 0) unplug();
      device.transmit(now);  // lost
      return;
    }
    if (master < 0) {
      try {
        plug_in();
      } catch (const InvalidInput&) {
        return;  // tried again in the next turn
      }
    }
    char buffer[4096];
    const ssize_t n = ::read(master, buffer, sizeof buffer);
    if (n > 0) device.receive({buffer, static_cast<std::size_t>(n)}, now);
    const std::string bytes = device.transmit(now);
    // What the program does not fetch overflows, as in a real port.
    if (!bytes.empty() && ::write(master, bytes.data(), bytes.size()) < 0 && errno != EAGAIN) return;
  }

  SimulatedDevice device;
  HostClock& clock;
  std::string folder, path;
  int master = -1;
  std::mutex mutex;
  std::atomic<bool> stop{false};
  std::thread server;
};

PseudoTerminal::PseudoTerminal(SimulatedDevice device, HostClock& clock)
    : implementation_(std::make_unique<Implementation>(std::move(device), clock)) {}

PseudoTerminal::~PseudoTerminal() = default;

const std::string& PseudoTerminal::path() const {
  return implementation_->path;
}

std::vector<std::pair<std::int64_t, std::string>> PseudoTerminal::keys() {
  const std::lock_guard lock(implementation_->mutex);
  return implementation_->device.keys(implementation_->clock.now_us());
}

bool PseudoTerminal::finished() const {
  const std::lock_guard lock(implementation_->mutex);
  return implementation_->device.finished(implementation_->clock.now_us());
}

std::unique_ptr<ByteStream> connect_directly(SimulatedDevice& device, VirtualClock& clock) {
  return std::make_unique<DirectStream>(device, clock);
}

}  // namespace batten
