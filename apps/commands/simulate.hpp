#pragma once
#include "commands/json.hpp"

#include <cstdint>
#include <optional>
#include <string>

#include "batten/core/progress.hpp"
#include "batten/simulation/mesh_sections.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate.hpp"
#include "batten/simulation/simulate_device.hpp"

namespace batten::commands {

/// Options of `simulate` in the words of users, with their defaults (docs/simulate.md); of pens none.
struct SimulateArguments {
  std::string axes = "x,y,z";
  std::uint64_t seed = 0;
  std::string step = "0.6%", orientation_noise = "0", drift = "0", drift_length = "15%", odometer_error = "0",
              outliers = "0", disturbance = "0", curve_length_error = "0", truth_step = "0.05%",
              truth_edge = "0.3%";
  double jitter = SimulateOptions().jitter;
  double sensor_noise = 1;
  int dwell = SimulateOptions().dwell;
  int planes = MeshSectionOptions().planes;
  std::string speed_variation = "0", nodes = "numbered";
  bool raw = false;
  bool distortion = true;
  bool gyroscope = false;
  double gyroscope_rate = GyroscopeOptions().rate, gyroscope_warming = GyroscopeOptions().warming;
  std::string gyroscope_bias, gyroscope_walk, gyroscope_scale, gyroscope_misalignment, gyroscope_temperature;
};

/// What is scanned.
struct SimulatedObject {
  TracedNetwork traced;
  std::optional<TriangleMesh> mesh;  ///< where it is one
  std::optional<AnalyticShape> shape;
};

/// The curves of a shape of this name. @throws UsageError where there is none, or it may be a file.
SimulatedObject traced_shape(const std::string& name);
/// The curves of a mesh. @throws InvalidInput as trace_mesh(); UsageError on options out of range.
SimulatedObject traced_mesh(TriangleMesh mesh, const SimulateArguments& arguments);

/// A scan, or what the sensors of a device wrote meanwhile.
struct Simulation {
  SimulatedScan simulated;
  std::optional<SensorLog> log;     ///< with option `raw`
  std::optional<SensorLog> tumble;  ///< of the same device, where it was asked for
};

/// @throws UsageError on options that are out of range or do not go together; InvalidInput on words that do
/// not parse.
SimulateOptions options_of(const SimulateArguments& arguments, double diameter);
/// Fails as simulate() does on what does not depend on the object.
void check_arguments(const SimulateArguments& arguments, bool tumble);
Simulation simulate(const SimulateArguments& arguments, const SimulatedObject& object, bool tumble);

/// The true curves, and the true surface.
CurveNetwork true_network(const SimulateArguments& arguments, const SimulatedObject& object);
TriangleMesh true_mesh(const SimulateArguments& arguments, const SimulatedObject& object);

/// @pre the scan still has the numbers of its nodes.
Json figures_of(const SimulatedObject& object, const SimulatedScan& simulated);

/// Leaves out the numbers of the nodes ("stays"), or the nodes altogether ("none"): a device that only rests
/// there.
void leave_out_numbers(const std::string& nodes, Scan& scan);

}  // namespace batten::commands
