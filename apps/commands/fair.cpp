#include "commands/fair.hpp"

#include <cmath>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"

namespace batten::commands {

double parse_noise(const std::string& text) {
  double value = -1;
  if (text != "auto" && !(parse_number(text, value) && std::isfinite(value) && value >= 0))
    throw InvalidInput(concat("--noise must be auto or a number of mean edge lengths, at least 0: ", text));
  return value;
}

FairingOptions options_of(const FairArguments& arguments) {
  FairingOptions options;
  options.method = parse_choice<FairingMethod>(arguments.method);
  options.noise = parse_noise(arguments.noise);
  options.iterations = arguments.iterations;
  options.keep_boundary = arguments.keep_boundary;
  return options;
}

std::string strategy_of(const FairArguments& arguments, const FairedMesh& faired) {
  return std::string(faired.strategy ? word_of(*faired.strategy)
                                     : word_of(parse_choice<FairingMethod>(arguments.method)));
}

Json figures_of(const FairArguments& arguments, const FairedMesh& faired) {
  Json figures = Json::object();
  figures["vertices"] = faired.mesh.n_vertices();
  figures["faces"] = faired.mesh.n_triangles();
  figures["components"] = faired.topology.n_components;
  figures["boundary_loops"] = faired.topology.n_boundary_loops;
  figures["method"] = arguments.method;
  figures["strategy"] = strategy_of(arguments, faired);
  figures["noise"] = faired.noise;
  figures["iterations"] = faired.iterations;
  figures["time_step"] = faired.time_step > 0 ? Json(faired.time_step) : Json(nullptr);
  figures["largest_move"] = faired.largest_move;
  figures["mean_normal_change_deg"] = degrees(faired.mean_normal_change);
  figures["volume_change_percent"] = nullptr;
  if (faired.volume_change) figures["volume_change_percent"] = 100 * *faired.volume_change;
  return figures;
}

}  // namespace batten::commands
