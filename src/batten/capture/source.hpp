#pragma once
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "batten/capture/byte_stream.hpp"
#include "batten/capture/clock.hpp"
#include "batten/capture/recording.hpp"

namespace batten {

/// What a source is doing.
struct SourceState {
  enum class Kind {
    Closed,
    Open,   ///< readings come, or may
    Ended,  ///< nothing more will come: a replay or a simulation is over
  };
  Kind kind = Kind::Closed;
  std::string reason;  ///< in words; may be empty
};

/// Where events come from. The session above (capture.hpp) opens it anew when it is lost, marks gaps and
/// records; a source does none of that.
class Source {
 public:
  virtual ~Source() = default;
  /// @throws InvalidInput with the remedy, where the device is not there or may not be used.
  virtual void open() = 0;
  /// Waits at most `seconds` for something and appends what came, with host times.
  /// @throws SourceLost when the connection is gone or silent.
  virtual void poll(double seconds, std::vector<CaptureEvent>& events) = 0;
  virtual void close() = 0;
  virtual SourceState state() const = 0;
  /// The header of a recording that is replayed; nothing for devices.
  virtual const RecordingHeader* header() const { return nullptr; }
};

/// Opens the way to a device, each time anew.
using StreamOpener = std::function<std::unique_ptr<ByteStream>()>;

/// Asks a Morphorider for a packet every 10 ms and reads exactly 22 bytes within 50 ms. After a short answer
/// it waits for 20 ms of silence and throws away what came meanwhile, so that no packet is put together from
/// two. Three short answers in a row are SourceLost. Packets are stamped with the time of their request.
std::unique_ptr<Source> make_morphorider_source(StreamOpener open_stream, HostClock& clock);

/// Reads lines. Asks for the header and sends `start` when it is opened.
/// @param longest_silence seconds without a line that are SourceLost; 0: a source that may be silent, such as
/// a phone at rest.
std::unique_ptr<Source> make_line_source(StreamOpener open_stream, HostClock& clock, double longest_silence);

/// Gives the events of a recording with their own times, as the clock reaches them.
std::unique_ptr<Source> make_replay_source(Recording recording, HostClock& clock);

/// The SOURCE of the command line, taken apart: `KIND:ADDRESS[@BAUD][?OPTION=VALUE&…]`.
struct SourceSpec {
  enum class Kind { Morphorider, Line, WebSocket, Udp, File, Simulator };

  Kind kind = Kind::Simulator;
  std::string address;  ///< port, file, network interface, or name of a motion
  int number = 0;       ///< baud, or network port
  std::map<std::string, std::string> options;
};

/// @throws InvalidInput naming the forms there are.
SourceSpec parse_source(std::string_view text);

/// The clock that belongs to a source: real time, but for simulators and replays with a speed of their own
/// (`speed=N`; `speed=max`: virtual time).
std::unique_ptr<HostClock> make_clock(const SourceSpec& spec);

/// @throws InvalidInput when an option is not known, or as the source. Simulators:
/// docs/capture.md#simulators.
std::unique_ptr<Source> make_source(const SourceSpec& spec, HostClock& clock);

/// Serial ports that this computer has and a device may be at: /dev/ttyUSB0.
std::vector<std::string> serial_ports();

/// Sources that this computer has, as they are given on the command line, each with a word on it.
std::vector<std::pair<std::string, std::string>> list_sources();

}  // namespace batten
