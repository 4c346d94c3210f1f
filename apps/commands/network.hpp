#pragma once
#include "commands/json.hpp"

#include <string>

#include "batten/scan/node_inference.hpp"
#include "batten/scan/reconstruct.hpp"

namespace batten::commands {

/// The way from a scan to a network, as `network` and `reconstruct` share it: options in the words of users,
/// with their defaults (docs/network.md).
struct NetworkArguments {
  std::string nodes = "given";
  std::string step = "1.6%", weights = "auto", energy = "scaled", robust = "on", scheme = "midpoint",
              lengths = "measured";
  double xi = 10000;
  bool uncertainty = false;
};

/// Those of single options. @throws InvalidInput on words that do not parse.
void parse_step(const std::string& text, ScanOptions& options);
void parse_weights(const std::string& text, ScanOptions& options);

/// @throws InvalidInput on words that do not parse; UsageError on values that do not go together.
ScanOptions options_of(const NetworkArguments& arguments);

/// Nodes with their evidence: "inferred_nodes".
Json figures_of(const NodeInference& found);

/// All but how sure it is.
Json figures_of(const ScanNetwork& result);

}  // namespace batten::commands
