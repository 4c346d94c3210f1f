#include "studio/capture_sources.hpp"

#include <algorithm>

#include "batten/capture/source.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/simulation/shapes.hpp"

namespace batten::studio {

std::vector<std::pair<std::string, std::string>> offered_sources() {
  std::vector<std::pair<std::string, std::string>> found = list_sources();
  std::stable_partition(found.begin(), found.end(), [](const auto& entry) {
    return parse_source(entry.first).kind == SourceSpec::Kind::Simulator;
  });
  return found;
}

void check_offered(const std::string& source) {
  const SourceSpec spec = parse_source(source);
  switch (spec.kind) {
    case SourceSpec::Kind::Simulator:
      parse_choice<AnalyticShape>(spec.address);
      return;
    case SourceSpec::Kind::Morphorider:
    case SourceSpec::Kind::Line: {
      const std::vector<std::string> ports = serial_ports();
      if (std::find(ports.begin(), ports.end(), spec.address) == ports.end())
        throw InvalidInput(concat("there is no serial port ", spec.address,
                                  " at this computer; plug the device in, or use `batten capture` for ports "
                                  "of other names"));
      return;
    }
    case SourceSpec::Kind::WebSocket:
    case SourceSpec::Kind::Udp:
      if (spec.address != "127.0.0.1")
        throw InvalidInput(concat("the studio listens to 127.0.0.1 alone, not to ", spec.address,
                                  "; `batten capture` opens it to a network"));
      return;
    case SourceSpec::Kind::File:
      throw InvalidInput("recordings are replayed by their number in the folder");
  }
}

}  // namespace batten::studio
