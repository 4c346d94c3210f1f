#include "command.hpp"
#include "pen_arguments.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/io/network_io.hpp"
#include "batten/io/scan_io.hpp"
#include "batten/io/sensor_log_io.hpp"
#include "batten/io/standard_streams.hpp"
#include "batten/simulation/mesh_sections.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate.hpp"
#include "batten/simulation/simulate_device.hpp"

namespace batten::cli {

namespace {

struct SimulateArguments {
  std::string object, output, truth, truth_network, tumble, axes = "x,y,z";
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
  GyroscopeOptions gyroscope_errors;
  std::string gyroscope_bias, gyroscope_walk, gyroscope_scale, gyroscope_misalignment, gyroscope_temperature;
  SimulatePenArguments pen;
};

CLI::Validator length_text() {
  return parses("LENGTH", [](std::string_view text) {
    if (!(parse_length(text).value > 0)) throw InvalidInput(concat("a length must be above 0, got ", text));
  });
}

CLI::Validator angle_text() {
  return parses("ANGLE", [](std::string_view text) { parse_angle(text); });
}

CLI::Validator fraction_text() {
  return parses("FRACTION", [](std::string_view text) {
    const double value = parse_fraction(text);
    if (!(value >= 0 && value <= 1))
      throw InvalidInput(concat("a fraction lies between 0 and 100 %, got ", text));
  });
}

/// A length as a fraction of the diameter.
double relative_length(const std::string& text, double diameter) {
  return parse_length(text).in_file_units(diameter) / diameter;
}

/// The options that do not depend on the object. @throws CLI::ValidationError when one is out of range.
SimulateOptions options_of(const SimulateArguments& arguments) {
  SimulateOptions options;
  options.seed = arguments.seed;
  options.jitter = arguments.jitter;
  options.dwell = arguments.dwell;
  options.orientation_noise = parse_angle(arguments.orientation_noise);
  options.drift = parse_angle(arguments.drift);
  options.odometer_error = parse_fraction(arguments.odometer_error);
  options.outliers = parse_fraction(arguments.outliers);
  options.disturbance = parse_angle(arguments.disturbance);
  options.curve_length_error = parse_fraction(arguments.curve_length_error);
  options.speed_variation = parse_fraction(arguments.speed_variation);
  if (const auto problem = options.problem()) throw CLI::ValidationError(*problem);
  return options;
}

/// The gyroscope that was asked for. @throws CLI::ValidationError when an option is out of range.
GyroscopeOptions gyroscope_of(const SimulateArguments& arguments, double noise) {
  GyroscopeOptions options = arguments.gyroscope_errors;
  const auto angle = [](const std::string& text, double& value) {
    if (!text.empty()) value = parse_angle(text);
  };
  angle(arguments.gyroscope_bias, options.bias);
  angle(arguments.gyroscope_walk, options.walk);
  angle(arguments.gyroscope_misalignment, options.misalignment);
  angle(arguments.gyroscope_temperature, options.temperature);
  if (!arguments.gyroscope_scale.empty()) options.scale = parse_fraction(arguments.gyroscope_scale);
  options.noise = noise;
  if (const auto problem = options.problem()) throw CLI::ValidationError(*problem);
  return options;
}

struct SimulatedObject {
  TracedNetwork traced;
  std::optional<TriangleMesh> mesh;  // of a mesh file
  std::optional<AnalyticShape> shape;
};

SimulatedObject load_object(const SimulateArguments& arguments, Outcome& outcome) {
  SimulatedObject object;
  if (const auto shape = choices_of(AnalyticShape{}).find(arguments.object)) {
    object.shape = *shape;
    object.traced = trace_shape(*shape);
    return object;
  }
  if (arguments.object.find('.') == std::string::npos) {
    std::string names;
    for (const std::string& name : choice_words<AnalyticShape>()) names += (names.empty() ? "" : ", ") + name;
    throw CLI::ValidationError(
        concat("'", arguments.object, "' is neither a shape (", names, ") nor a mesh file"));
  }
  object.mesh = read_mesh(arguments.object, &outcome.warnings);
  MeshSectionOptions options;
  options.planes = arguments.planes;
  options.axes.clear();
  for (const std::string_view axis : split_fields(arguments.axes, ',')) options.axes += axis;
  if (const auto problem = options.problem()) throw CLI::ValidationError(*problem);
  try {
    object.traced = trace_mesh(*object.mesh, options);
  } catch (const FileError&) {
    throw;
  } catch (const InvalidInput& error) {
    throw FileError(arguments.object, 0, error.what());
  }
  return object;
}

void check_outputs(const SimulateArguments& arguments, Outcome& outcome) {
  const std::string extension = output_extension(arguments.output, arguments.raw ? "csv" : "rawnet");
  if (!arguments.raw && extension != "rawnet")
    throw CLI::ValidationError(concat("--output: a scan is written as .rawnet, got ", arguments.output));
  if (arguments.raw && extension != "csv")
    outcome.warnings.push_back(concat(arguments.output,
                                      " is a sensor log in comma-separated values; .csv tells "
                                      "so"));
  if (arguments.gyroscope && !arguments.raw)
    throw CLI::ValidationError("--gyroscope needs --raw: a scan of orientations has no gyroscope");
  if (arguments.nodes != "numbered" && arguments.raw)
    throw CLI::ValidationError("--nodes is for scans of orientations: logs of --raw number their nodes");
  if (!arguments.tumble.empty() && !arguments.raw)
    throw CLI::ValidationError("--tumble needs --raw: a scan of orientations has no sensors to calibrate");
  try {
    if (!arguments.truth.empty()) mesh_format(arguments.truth);
    if (!arguments.truth_network.empty()) network_format(arguments.truth_network);
  } catch (const InvalidInput& error) {
    throw CLI::ValidationError(error.what());
  }
}

void write_truth(const SimulateArguments& arguments, const SimulatedObject& object, Outcome& outcome) {
  const double diameter = object.traced.diameter;
  if (!arguments.truth_network.empty()) {
    const double step = parse_length(arguments.truth_step).in_file_units(diameter);
    const CurveNetwork network = truth_network(object.traced, step);
    write_network(arguments.truth_network, network);
    outcome.figures["truth_network_vertices"] = network.positions.rows();
    outcome.lines.push_back(concat("true network: ", arguments.truth_network));
  }
  if (arguments.truth.empty()) return;
  const TriangleMesh mesh =
      object.mesh ? *object.mesh : shape_mesh(*object.shape, relative_length(arguments.truth_edge, diameter));
  write_mesh(arguments.truth, mesh);
  outcome.figures["truth_faces"] = mesh.n_triangles();
  outcome.lines.push_back(concat("true surface: ", arguments.truth));
}

/// Leaves out the numbers of the nodes, or the nodes altogether: a device that only rests there.
void leave_out_numbers(const std::string& nodes, Scan& scan) {
  for (ScanCurve& curve : scan.curves) {
    if (nodes == "stays") std::fill(curve.node_ids.begin(), curve.node_ids.end(), kNoNodeNumber);
    if (nodes != "none") continue;
    curve.node_readings.clear();
    curve.node_ids.clear();
  }
}

void add_figures(Json& figures, const SimulatedObject& object, const SimulatedScan& simulated) {
  const Scan& scan = simulated.scan;
  Eigen::Index readings = 0;
  size_t segments = 0;
  int boundary_curves = 0;
  double length = 0;
  for (size_t c = 0; c < scan.curves.size(); ++c) {
    const ScanCurve& curve = scan.curves[c];
    readings += curve.n_readings();
    segments += std::max<size_t>(curve.node_ids.size(), 2) - 1;
    boundary_curves += curve.boundary ? 1 : 0;
    length += object.traced.curves[c].path->length();
  }
  figures["curves"] = scan.curves.size();
  figures["nodes"] = object.traced.node_positions.rows();
  figures["segments"] = segments;
  figures["boundary_curves"] = boundary_curves;
  figures["readings"] = readings;
  figures["diameter"] = object.traced.diameter;
  figures["length"] = length;
  const SimulateReport& report = simulated.report;
  Json drawn = Json::object();
  drawn["orientation_noise_deg"] = degrees(report.rms_orientation_noise);
  drawn["drift_deg"] = degrees(report.rms_drift);
  drawn["distance_factors"] = report.distance_factors;
  drawn["outliers"] = report.n_outliers;
  drawn["disturbed_curve"] = report.disturbed_curve < 0 ? Json(nullptr) : Json(report.disturbed_curve + 1);
  if (report.disturbed_curve >= 0) drawn["disturbed_at"] = report.disturbed_centre;
  figures["drawn"] = drawn;
}

Outcome run_simulate(const SimulateArguments& arguments, const Progress& progress) {
  if (arguments.object == "pen")
    return run_simulate_pen(arguments.pen, arguments.output, arguments.truth, arguments.seed, progress);
  Outcome outcome;
  check_outputs(arguments, outcome);
  SimulateOptions options = options_of(arguments);
  SimulatedObject object;
  {
    const ScopedStage stage(outcome.times, "trace");
    object = load_object(arguments, outcome);
  }
  const double diameter = object.traced.diameter;
  options.step = relative_length(arguments.step, diameter);
  options.drift_length = relative_length(arguments.drift_length, diameter);
  if (const auto problem = options.problem()) throw CLI::ValidationError(*problem);
  outcome.warnings.insert(outcome.warnings.end(), object.traced.warnings.begin(),
                          object.traced.warnings.end());

  SimulatedScan simulated;
  std::optional<SensorLog> log;
  std::optional<SensorLog> tumble;
  {
    const ScopedStage stage(outcome.times, "simulate");
    simulated = simulate_scan(object.traced, options);
    if (arguments.raw) {
      DeviceModel device = make_device(arguments.seed, arguments.sensor_noise);
      if (!arguments.distortion) {
        DeviceModel ideal;
        ideal.accelerometer_noise = device.accelerometer_noise;
        ideal.magnetometer_noise = device.magnetometer_noise;
        ideal.gyroscope_noise = device.gyroscope_noise;
        ideal.knocks = device.knocks;
        device = ideal;
      }
      if (arguments.gyroscope)
        add_gyroscope(device, gyroscope_of(arguments, device.gyroscope_noise), arguments.seed);
      log = simulate_log(object.traced, simulated, device, arguments.seed);
      if (!arguments.tumble.empty()) tumble = simulate_tumble(device, arguments.seed);
    }
  }
  const ScopedStage stage(outcome.times, "write");
  add_figures(outcome.figures, object, simulated);
  outcome.figures["output"] = arguments.output;
  outcome.lines.push_back(concat(simulated.scan.curves.size(), " curves, ", outcome.figures["nodes"].dump(),
                                 " nodes, ", outcome.figures["readings"].dump(),
                                 " readings: ", arguments.output));
  if (log) {
    write_sensor_log(*log, arguments.output);
  } else {
    leave_out_numbers(arguments.nodes, simulated.scan);
    write_rawnet(simulated.scan, arguments.output);
  }
  if (tumble) {
    write_sensor_log(*tumble, arguments.tumble);
    outcome.lines.push_back(concat("tumbling recording: ", arguments.tumble));
  }
  write_truth(arguments, object, outcome);
  return outcome;
}

void add_gyroscope_options(CLI::App& command, SimulateArguments& a) {
  CLI::Option* gyroscope = command.add_flag(
      "--gyroscope", a.gyroscope,
      "With --raw: a gyroscope that is read all the time, in rows of its own, also between the curves");
  const auto needs = [&](CLI::Option* option) { return option->needs(gyroscope); };
  needs(command.add_option("--gyroscope-rate", a.gyroscope_errors.rate, "Its readings per second"))
      ->check(CLI::Range(1.0, 10000.0));
  needs(command.add_option("--gyroscope-bias", a.gyroscope_bias,
                           "Spread of its bias, an angle per second (0.57deg)"))
      ->check(angle_text());
  needs(command.add_option("--gyroscope-walk", a.gyroscope_walk,
                           "How the bias walks, an angle per second and root second (0.0011deg)"))
      ->check(angle_text());
  needs(command.add_option("--gyroscope-scale", a.gyroscope_scale, "Spread of its scale error (0.5%)"))
      ->check(fraction_text());
  needs(command.add_option("--gyroscope-misalignment", a.gyroscope_misalignment,
                           "Spread of the angles of its axes (0.29deg)"))
      ->check(angle_text());
  needs(command.add_option("--gyroscope-temperature", a.gyroscope_temperature,
                           "Spread of the change of the bias per kelvin, an angle per second (0.029deg)"))
      ->check(angle_text());
  needs(command.add_option("--gyroscope-warming", a.gyroscope_errors.warming,
                           "By how many kelvins the device grows warmer, within some minutes"))
      ->check(CLI::Range(0.0, 100.0));
}

}  // namespace

void add_simulate(CLI::App& app) {
  auto arguments = std::make_shared<SimulateArguments>();
  SimulateArguments& a = *arguments;
  CLI::App* command = add_command(
      app, "simulate", "Simulate the scan of a shape or of a mesh, with its truth",
      "batten simulate torus -o scan.rawnet --truth truth.ply --orientation-noise 2deg --drift 1deg",
      [arguments](Context& context) { return run_simulate(*arguments, context.progress); });
  command
      ->add_option("object", a.object,
                   "sphere, sphere6, ellipsoid, torus, bumpycube, saddle, waves, dish, cone, a mesh file "
                   "(ply, obj, off, stl), or pen: what two cameras see of one that draws")
      ->required();
  command
      ->add_option("-o,--output", a.output,
                   "The scan, .rawnet; with --raw a sensor log, .csv; of a pen its blobs, .jsonl")
      ->required();
  command->add_option(
      "--truth", a.truth,
      "Write the true surface as a mesh (.ply, .obj, .off, .stl); of a pen its true poses (.csv)");
  command->add_option("--truth-network", a.truth_network, "Write the true curves (.net, .obj, .json)");
  command->add_option("--seed", a.seed, "Seed of all random numbers");
  command->add_option("--step", a.step, "Mean distance between readings")->check(length_text());
  command->add_option("--jitter", a.jitter, "Largest shift of a reading, in steps")
      ->check(CLI::Range(0.0, 0.49));
  command->add_option("--dwell", a.dwell, "Readings at every node")->check(CLI::Range(1, 1000));
  command->add_option("--orientation-noise", a.orientation_noise, "White noise of the frames, per axis")
      ->check(angle_text());
  command->add_option("--drift", a.drift, "Slow drift of the frames, per axis")->check(angle_text());
  command->add_option("--drift-length", a.drift_length, "Distance over which the drift forgets itself")
      ->check(length_text());
  command->add_option("--odometer-error", a.odometer_error, "Spread of the scale of distances, per curve")
      ->check(fraction_text());
  command->add_option("--outliers", a.outliers, "Fraction of readings with a random orientation")
      ->check(fraction_text());
  command
      ->add_option("--disturbance", a.disturbance,
                   "Turn the heading on a tenth of one curve by up to this angle")
      ->check(angle_text());
  command
      ->add_option("--curve-length-error", a.curve_length_error, "Curve lengths wrong by up to this fraction")
      ->check(fraction_text());
  command
      ->add_option(
          "--speed-variation", a.speed_variation,
          "Distances from time stamps: the speed goes up and down by up to this fraction along a curve")
      ->check(fraction_text());
  command
      ->add_option(
          "--nodes", a.nodes,
          "numbered; stays: marked where they are, without numbers; none: no marks, the device rests")
      ->check(CLI::IsMember({"numbered", "stays", "none"}));
  command->add_flag("--raw", a.raw, "Write raw readings of accelerometer, magnetometer and gyroscope");
  command->add_option("--tumble", a.tumble,
                      "With --raw: write a recording for batten calibrate as well (.csv)");
  command
      ->add_option("--sensor-noise", a.sensor_noise,
                   "With --raw: factor on the noise of the sensors; 0: none")
      ->check(CLI::Range(0.0, 100.0));
  command->add_flag("--distortion,!--no-distortion", a.distortion,
                    "With --raw: zero errors, scales and soft iron that need a calibration");
  add_gyroscope_options(*command, a);
  command->add_option("--planes", a.planes, "Meshes: planes per axis")->check(CLI::Range(1, 100));
  command->add_option("--axes", a.axes, "Meshes: axes across which planes are laid, such as x,z");
  command->add_option("--truth-step", a.truth_step, "Distance between the points of the true curves")
      ->check(length_text());
  command->add_option("--truth-edge", a.truth_edge, "Length of the edges of a shape's true mesh")
      ->check(length_text());
  add_simulate_pen_options(*command, a.pen);
}

}  // namespace batten::cli
