#include "command.hpp"
#include "model_file.hpp"
#include "stroke_arguments.hpp"

#include <memory>
#include <optional>
#include <string>

#include "batten/capture/decode.hpp"
#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/io/network_io.hpp"
#include "batten/io/scan_io.hpp"
#include "batten/io/sensor_log_io.hpp"
#include "batten/io/standard_streams.hpp"
#include "batten/network/resample.hpp"
#include "batten/strokes/snapping.hpp"

namespace batten::cli {

namespace {

struct ConvertArguments {
  std::string in, out, resample, weld, columns, unit, calibration, wheel;
  bool ascii = false, sketch = false;
};

/// A length option in the unit of the network.
double length_in(const CurveNetwork& network, const std::string& text) {
  double metres_per_unit = 1;
  if (!network.unit.empty()) {
    try {
      const Length one = parse_length("1" + network.unit);
      if (one.kind == Length::Kind::Metres) metres_per_unit = one.value;
    } catch (const InvalidInput&) {
      throw InvalidInput(concat("the unit of the network is '", network.unit,
                                "', which is no known unit of length; give a plain number or a percentage"));
    }
  }
  const Length length = parse_length(text);
  return length.in_file_units(bounding_box_diagonal(network.positions), metres_per_unit);
}

void require(bool holds, const std::string& problem) {
  if (!holds) throw CLI::ValidationError(problem);
}

void convert_network(CurveNetwork network, const ConvertArguments& arguments, const Context& context,
                     Outcome& outcome) {
  const NetworkFormat format = network_format(arguments.out);
  if (arguments.sketch) {
    if (network.has_normals())
      throw InvalidInput(concat(arguments.in, " has normals, so it is no sketch; leave --sketch out"));
    StrokeNetwork strokes = stroke_network(network, {}, context.progress);
    tell_strokes({}, strokes, outcome);
    outcome.figures["cycles"] = strokes.estimate.cycles.size();
    network = std::move(strokes.network);
  }
  if (!arguments.weld.empty()) {
    ScopedStage stage(outcome.times, "weld");
    WeldedNetwork joined = welded(network, length_in(network, arguments.weld));
    network = std::move(joined.network);
    const WeldReport& report = joined.report;
    outcome.figures["merged_vertices"] = report.n_merged_vertices;
    outcome.figures["inserted_nodes"] = report.n_inserted_nodes;
    outcome.figures["removed_curves"] = report.n_removed_curves;
    outcome.lines.push_back(concat("welded: ", report.n_merged_vertices, " vertices merged, ",
                                   report.n_inserted_nodes, " nodes inserted"));
    if (report.n_removed_curves > 0)
      outcome.warnings.push_back(
          concat(report.n_removed_curves, " curves shorter than the weld tolerance were removed"));
  }
  if (!arguments.resample.empty()) {
    ScopedStage stage(outcome.times, "resample");
    const double step = length_in(network, arguments.resample);
    network = resampled(network, step);
    outcome.figures["step"] = step;
  }
  for (const std::string& loss : losses_in_format(network, format)) outcome.warnings.push_back(loss);
  {
    ScopedStage stage(outcome.times, "write");
    write_network(arguments.out, network);
  }
  const NetworkTopology topology = network_topology(network);
  outcome.figures["kind"] = "network";
  outcome.figures["curves"] = network.curves.size();
  outcome.figures["nodes"] = topology.nodes.size();
  outcome.figures["segments"] = topology.segments.size();
  outcome.figures["components"] = topology.n_components;
  outcome.figures["vertices"] = network.positions.rows();
  outcome.lines.push_back(concat(arguments.out, ": ", network.curves.size(), " curves, ",
                                 topology.nodes.size(), " nodes, ", network.positions.rows(), " vertices"));
}

void convert_mesh(const MeshFile& file, const ConvertArguments& arguments, Outcome& outcome) {
  require(arguments.resample.empty() && arguments.weld.empty() && !arguments.sketch,
          "--resample, --weld and --sketch are for networks; " + arguments.in + " is a mesh");
  const MeshFormat format = mesh_format(arguments.out);
  const TriangleMesh& mesh = file.mesh;
  MeshWriteOptions options;
  options.ascii = arguments.ascii;
  if (!arguments.unit.empty()) {
    options.metres_per_unit = metres_per_unit(arguments.unit);
    outcome.figures["unit"] = arguments.unit;
    if (!has_unit(format))
      outcome.warnings.push_back(concat(
          arguments.out, " cannot say its unit: its numbers stay those of the input, in ", arguments.unit));
  }
  for (const std::string& loss : losses_in_format(mesh, format, options)) outcome.warnings.push_back(loss);
  for (const std::string& loss : losses_in_format(file.attributes, format)) outcome.warnings.push_back(loss);
  {
    ScopedStage stage(outcome.times, "write");
    write_mesh_file(arguments.out, file, options);
  }
  outcome.figures["kind"] = "mesh";
  outcome.figures["vertices"] = mesh.n_vertices();
  outcome.figures["faces"] = mesh.n_triangles();
  outcome.lines.push_back(
      concat(arguments.out, ": ", mesh.n_vertices(), " vertices, ", mesh.n_triangles(), " faces"));
}

void convert_scan(const ConvertArguments& arguments, Outcome& outcome) {
  require(arguments.resample.empty() && arguments.weld.empty() && !arguments.sketch,
          "--resample, --weld and --sketch are for networks; " + arguments.in + " is a scan");
  const bool is_log = input_extension(arguments.in) == "csv" || !arguments.columns.empty();
  if (output_extension(arguments.out, "rawnet") != "rawnet")
    throw FileError(arguments.out, 0,
                    "a scan is written as .rawnet; to get a network from it use `batten network`");
  LogScan scan;
  {
    ScopedStage stage(outcome.times, "read");
    scan = read_scan(arguments.in, {}, arguments.columns);
  }
  for (const std::string& warning : scan.warnings) outcome.warnings.push_back(warning);
  if (is_log)
    outcome.warnings.emplace_back(
        "orientations were estimated without a calibration; rawnet holds neither the raw readings nor their "
        "times");
  {
    ScopedStage stage(outcome.times, "write");
    write_rawnet(scan.scan, arguments.out);
  }
  long n_readings = 0;
  for (const ScanCurve& curve : scan.scan.curves) n_readings += curve.n_readings();
  outcome.figures["kind"] = "scan";
  outcome.figures["curves"] = scan.scan.curves.size();
  outcome.figures["readings"] = n_readings;
  outcome.lines.push_back(
      concat(arguments.out, ": ", scan.scan.curves.size(), " curves, ", n_readings, " readings"));
}

/// A recording of `batten capture` into a sensor log or, with orientations, into a scan.
void convert_recording(const ConvertArguments& arguments, Outcome& outcome) {
  require(arguments.resample.empty() && arguments.weld.empty() && !arguments.sketch,
          "--resample, --weld and --sketch are for networks; " + arguments.in + " is a recording");
  const std::string format = output_extension(arguments.out, "rawnet");
  if (format != "rawnet" && format != "csv")
    throw FileError(arguments.out, 0, "a recording is written as .rawnet (a scan) or .csv (a sensor log)");
  DecodedRecording decoded;
  std::optional<LogScan> scan;
  std::optional<Calibration> calibration;
  if (!arguments.calibration.empty()) calibration = read_calibration(arguments.calibration);
  DecodeOptions options;
  if (!arguments.wheel.empty()) options.wheel_m = parse_length(arguments.wheel).value;
  {
    const ScopedStage stage(outcome.times, "decode");
    try {
      decoded = decode_recording(read_recording(arguments.in), options);
      if (format == "rawnet") scan = scan_from_recording(decoded, calibration);
    } catch (const FileError&) {
      throw;
    } catch (const InvalidInput& error) {
      throw FileError(arguments.in, 0, error.what());
    }
  }
  outcome.warnings = decoded.warnings;
  {
    const ScopedStage stage(outcome.times, "write");
    if (scan) {
      outcome.warnings.insert(outcome.warnings.end(), scan->warnings.begin(), scan->warnings.end());
      write_rawnet(scan->scan, arguments.out);
    } else {
      if (decoded.has_orientations())
        outcome.warnings.emplace_back(
            "a sensor log has no place for the orientations of the device itself; .rawnet has");
      write_sensor_log(decoded.log, arguments.out);
    }
  }
  const DecodeReport& report = decoded.report;
  outcome.figures["kind"] = scan ? "scan" : "log";
  outcome.figures["curves"] = decoded.log.curves.size();
  outcome.figures["readings"] = decoded.log.n_readings();
  outcome.figures["packets"] = report.n_packets;
  outcome.figures["lines"] = report.n_lines;
  outcome.figures["refused"] = report.n_refused;
  outcome.figures["duplicates"] = report.n_duplicates;
  outcome.figures["missing"] = report.n_missing;
  outcome.figures["form"] = report.form ? Json(std::string(word_of(report.form->form))) : Json(nullptr);
  outcome.lines.push_back(concat(arguments.out, ": ", decoded.log.curves.size(), " curves, ",
                                 decoded.log.n_readings(), " readings, ", report.n_refused, " refused"));
}

Outcome run_convert(const ConvertArguments& arguments, const Context& context) {
  Outcome outcome;
  outcome.figures["in"] = arguments.in;
  outcome.figures["out"] = arguments.out;
  const std::string extension = input_extension(arguments.in);
  if (extension == "blog") {
    convert_recording(arguments, outcome);
    return outcome;
  }
  if (extension == "rawnet" || extension == "csv" || !arguments.columns.empty()) {
    convert_scan(arguments, outcome);
    return outcome;
  }
  Model model;
  {
    ScopedStage stage(outcome.times, "read");
    model = read_model(arguments.in, outcome.warnings);
  }
  if (model.mesh)
    convert_mesh({std::move(*model.mesh), std::move(model.attributes)}, arguments, outcome);
  else
    convert_network(std::move(*model.network), arguments, context, outcome);
  return outcome;
}

/// Empty when the text is a length above 0, else what is wrong with it.
std::string length_problem(const std::string& text) {
  try {
    return parse_length(text).value > 0 ? std::string() : "must be more than 0: " + text;
  } catch (const InvalidInput& problem) {
    return problem.what();
  }
}

}  // namespace

void add_convert(CLI::App& app) {
  auto arguments = std::make_shared<ConvertArguments>();
  CLI::App* command =
      add_command(app, "convert", "Write a mesh, a network, a scan or a recording in another format.",
                  "batten convert sketch.obj net.json --weld 0.5% --resample 1.6%",
                  [arguments](Context& context) { return run_convert(*arguments, context); });
  command->add_option("IN", arguments->in, "Mesh, network, scan, or recording of batten capture (.blog)")
      ->required();
  command->add_option("OUT", arguments->out, "File to write; its extension decides the format")->required();
  add_columns_option(*command, arguments->columns);
  command->add_option("--calibration", arguments->calibration,
                      "Recordings: calibration of the device (.json) in place of the one in the recording");
  command
      ->add_option("--wheel", arguments->wheel,
                   "Recordings: circumference of a Morphorider's wheel, such as 62.8mm")
      ->check(parses("LENGTH", [](const std::string& text) {
        if (parse_length(text).kind == Length::Kind::Relative)
          throw InvalidInput(concat("the wheel must be a length, got ", text));
      }));
  command
      ->add_option("--weld", arguments->weld,
                   "Networks: make curves meet that come this near to each other (2mm, 0.5%)")
      ->check(length_problem);
  command
      ->add_option("--resample", arguments->resample,
                   "Networks: sample evenly along Hermite splines (0.05, 2mm, 1.6%)")
      ->check(length_problem);
  command->add_flag("--sketch", arguments->sketch,
                    "Networks without normals: mend and sample the strokes as `surface` does, with normals");
  command
      ->add_option(
          "--unit", arguments->unit,
          "Meshes: the unit of the numbers of IN (m, cm, mm, um, in, ft); .glb is written in metres, .3mf in "
          "millimetres; m where nothing is said")
      ->check(parses("UNIT", [](const std::string& text) { metres_per_unit(text); }));
  command->add_flag("--ascii", arguments->ascii, "Meshes: write PLY and STL as text");
}

}  // namespace batten::cli
