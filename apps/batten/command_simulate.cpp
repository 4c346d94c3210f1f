#include "command.hpp"
#include "commands/simulate.hpp"
#include "commands/words.hpp"
#include "pen_arguments.hpp"

#include <memory>
#include <string>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/io/network_io.hpp"
#include "batten/io/scan_io.hpp"
#include "batten/io/sensor_log_io.hpp"
#include "batten/io/standard_streams.hpp"

namespace batten::cli {

namespace {

struct SimulateArguments : commands::SimulateArguments {
  std::string object, output, truth, truth_network, tumble;
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

commands::SimulatedObject load_object(const SimulateArguments& arguments, Outcome& outcome) {
  if (choices_of(AnalyticShape{}).find(arguments.object) || arguments.object.find('.') == std::string::npos)
    return commands::traced_shape(arguments.object);
  TriangleMesh mesh = read_mesh(arguments.object, &outcome.warnings);
  try {
    return commands::traced_mesh(std::move(mesh), arguments);
  } catch (const commands::UsageError&) {
    throw;
  } catch (const InvalidInput& error) {
    throw FileError(arguments.object, 0, error.what());
  }
}

void check_outputs(const SimulateArguments& arguments, Outcome& outcome) {
  const std::string extension = output_extension(arguments.output, arguments.raw ? "csv" : "rawnet");
  if (!arguments.raw && extension != "rawnet")
    throw CLI::ValidationError(concat("--output: a scan is written as .rawnet, got ", arguments.output));
  if (arguments.raw && extension != "csv")
    outcome.warnings.push_back(concat(arguments.output,
                                      " is a sensor log in comma-separated values; .csv tells "
                                      "so"));
  check_arguments(arguments, !arguments.tumble.empty());
  try {
    if (!arguments.truth.empty()) mesh_format(arguments.truth);
    if (!arguments.truth_network.empty()) network_format(arguments.truth_network);
  } catch (const InvalidInput& error) {
    throw CLI::ValidationError(error.what());
  }
}

void write_truth(const SimulateArguments& arguments, const commands::SimulatedObject& object,
                 Outcome& outcome) {
  if (!arguments.truth_network.empty()) {
    const CurveNetwork network = true_network(arguments, object);
    write_network(arguments.truth_network, network);
    outcome.figures["truth_network_vertices"] = network.positions.rows();
    outcome.lines.push_back(concat("true network: ", arguments.truth_network));
  }
  if (arguments.truth.empty()) return;
  const TriangleMesh mesh = true_mesh(arguments, object);
  write_mesh(arguments.truth, mesh);
  outcome.figures["truth_faces"] = mesh.n_triangles();
  outcome.lines.push_back(concat("true surface: ", arguments.truth));
}

Outcome run_simulate(const SimulateArguments& arguments, const Progress& progress) {
  if (arguments.object == "pen")
    return run_simulate_pen(arguments.pen, arguments.output, arguments.truth, arguments.seed, progress);
  Outcome outcome;
  check_outputs(arguments, outcome);
  commands::SimulatedObject object;
  {
    const ScopedStage stage(outcome.times, "trace");
    object = load_object(arguments, outcome);
  }
  outcome.warnings.insert(outcome.warnings.end(), object.traced.warnings.begin(),
                          object.traced.warnings.end());

  commands::Simulation made;
  {
    const ScopedStage stage(outcome.times, "simulate");
    made = simulate(arguments, object, !arguments.tumble.empty());
  }
  const ScopedStage stage(outcome.times, "write");
  outcome.figures = commands::figures_of(object, made.simulated);
  outcome.figures["output"] = arguments.output;
  outcome.lines.push_back(concat(made.simulated.scan.curves.size(), " curves, ",
                                 outcome.figures["nodes"].dump(), " nodes, ",
                                 outcome.figures["readings"].dump(), " readings: ", arguments.output));
  if (made.log) {
    write_sensor_log(*made.log, arguments.output);
  } else {
    commands::leave_out_numbers(arguments.nodes, made.simulated.scan);
    write_rawnet(made.simulated.scan, arguments.output);
  }
  if (made.tumble) {
    write_sensor_log(*made.tumble, arguments.tumble);
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
  needs(command.add_option("--gyroscope-rate", a.gyroscope_rate, "Its readings per second"))
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
  needs(command.add_option("--gyroscope-warming", a.gyroscope_warming,
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
