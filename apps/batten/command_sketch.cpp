#include "command.hpp"
#include "model_surface_arguments.hpp"
#include "step_output.hpp"

#include <algorithm>
#include <memory>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/io/standard_streams.hpp"
#include "batten/session/journal.hpp"
#include "batten/session/playing.hpp"
#include "batten/session/project.hpp"
#include "batten/subdivision/bspline_blocks.hpp"
#include "batten/subdivision/bspline_surface.hpp"
#include "batten/subdivision/step.hpp"

namespace batten::cli {

namespace {

struct SketchArguments {
  std::string session, output, surface, step, model;
  ModelSurfaceArguments model_surface;
  bool strict = false, accept_flaws = false;
};

std::string id(char kind, int number) {
  return kind + std::to_string(number);
}

Json ids(char kind, const std::vector<int>& numbers) {
  Json list = Json::array();
  for (const int number : numbers) list.push_back(id(kind, number));
  return list;
}

/// The model with the ids of everything, for scripts that go on from here.
void describe(const PolylineMesh& mesh, Json& figures) {
  const SketchCounts counts = mesh.counts();
  figures["curves"] = counts.curves;
  figures["vertices"] = counts.vertices;
  figures["edges"] = counts.edges;
  figures["faces"] = counts.faces;
  figures["components"] = counts.components;
  figures["boundary_loops"] = counts.boundary_loops;
  figures["genus"] = counts.genus;
  figures["euler_characteristic"] = counts.euler_characteristic();
  std::vector<Json> curves(static_cast<size_t>(mesh.n_curves()));
  for (const SketchEdge& edge : mesh.edges()) {
    if (!edge.alive) continue;
    Json& curve = curves[static_cast<size_t>(edge.curve)];
    if (curve.is_null())
      curve = {{"id", id('c', edge.curve)},
               {"length", 0.0},
               {"sharpness", edge.sharpness},
               {"drawn", edge.drawn},
               {"edges", Json::array()}};
    curve["length"] = curve["length"].get<double>() + edge.polyline->length();
    curve["edges"].push_back({id('v', edge.vertices[0]), id('v', edge.vertices[1])});
  }
  figures["curve_list"] = Json::array();
  for (Json& curve : curves)
    if (!curve.is_null()) figures["curve_list"].push_back(std::move(curve));
  figures["vertex_list"] = Json::array();
  for (size_t v = 0; v < mesh.vertices().size(); ++v) {
    const SketchVertex& vertex = mesh.vertices()[v];
    if (vertex.alive)
      figures["vertex_list"].push_back(
          {{"id", id('v', static_cast<int>(v))},
           {"position", {vertex.position.x(), vertex.position.y(), vertex.position.z()}}});
  }
  figures["face_list"] = Json::array();
  for (size_t f = 0; f < mesh.faces().size(); ++f) {
    if (!mesh.faces()[f].alive) continue;
    std::vector<int> corners;
    for (const int side : mesh.faces()[f].sides) corners.push_back(mesh.start_of(side));
    figures["face_list"].push_back({{"id", id('f', static_cast<int>(f))}, {"corners", ids('v', corners)}});
  }
}

/// One edit that was done, for the JSON object.
Json describe(const SessionEdit& edit, const std::string& op, const EditOutcome& done) {
  Json json = {{"line", edit.line},
               {"op", op},
               {"curves", ids('c', done.report.curves)},
               {"vertices", ids('v', done.vertices)}};
  for (const std::string& remark : done.report.remarks) json["remarks"].push_back(remark);
  return json;
}

/// Plays a session; edits that are refused, or done late, are told.
void play(const Session& session, const std::string& path, Document& document, Context& context,
          Outcome& outcome) {
  Json edits = Json::array(), refused = Json::array();
  for (const PlayedEdit& played : play_session(session, document, context.progress)) {
    const SessionEdit& edit = session.edits[played.index];
    const std::string op = name_of_op(edit.edit);
    if (!played.done) {
      refused.push_back(
          {{"line", edit.line}, {"op", op}, {"reason", played.reason}, {"remedy", played.remedy}});
      outcome.lines.push_back(
          concat("line ", edit.line, ": ", op, " refused: ", played.reason, "; ", played.remedy));
      continue;
    }
    if (played.index < session.n_implied) continue;
    edits.push_back(describe(edit, op, *played.done));
    if (played.after != played.index) {
      const long after = session.edits[played.after].line;
      edits.back()["done_after_line"] = after;
      edits.back()["waited_for"] = played.reason;
      outcome.lines.push_back(concat("line ", edit.line, ": ", op, " done after line ", after,
                                     played.reason.empty() ? "" : concat("; in its turn ", played.reason)));
    }
    for (const std::string& remark : played.done->report.remarks)
      outcome.lines.push_back(concat("line ", edit.line, ": ", remark));
  }
  if (session.torn) outcome.warnings.push_back(session.warning(path));
  outcome.figures["edits_done"] = edits.size();
  outcome.figures["edits_refused"] = refused.size();
  outcome.figures["edits"] = std::move(edits);
  outcome.figures["refused"] = std::move(refused);
}

/// The model that is asked for, or the only one. @throws InvalidInput naming the models that there are.
ObjectId model_to_show(const Document& document, const std::string& name) {
  std::vector<ObjectId> models;
  std::string names;
  for (const ObjectId object : document.objects()) {
    if (document.object(object).kind() != ObjectKind::Model) continue;
    if (document.object(object).name == name) return object;
    names += (models.empty() ? "'" : ", '") + document.object(object).name + "'";
    models.push_back(object);
  }
  if (models.empty()) throw InvalidInput("there is no model of curves and faces in this project");
  if (!name.empty()) throw InvalidInput(concat("there is no model '", name, "'; there are ", names));
  if (models.size() > 1) throw InvalidInput(concat("there are several models; name one by --model: ", names));
  return models[0];
}

/// Millimetres in the unit of the session. @throws InvalidInput.
double millimetres_in(const std::string& unit) {
  const Length one = parse_length("1" + unit);
  if (one.kind != Length::Kind::Metres)
    throw InvalidInput(concat("the unit of the session is '", unit,
                              "'; STEP, glTF and 3MF need m, cm, mm, um, km, in or ft"));
  return 1000 * one.value;
}

void write_surface(const SketchArguments& arguments, const std::string& unit, TriangleMesh mesh,
                   Json& figures, Outcome& outcome) {
  const ScopedStage stage(outcome.times, "write");
  MeshWriteOptions options;
  if (has_unit(mesh_format(arguments.surface)) && !unit.empty())
    options.metres_per_unit = millimetres_in(unit) / 1000;
  write_mesh(arguments.surface, mesh, options);
  figures["vertices"] = mesh.n_vertices();
  figures["faces"] = mesh.n_triangles();
  outcome.lines.push_back(
      concat(arguments.surface, ": ", mesh.n_vertices(), " vertices, ", mesh.n_triangles(), " triangles"));
  outcome.exhibit.mesh = std::move(mesh);
}

void write_patches(const SketchArguments& arguments, const std::string& unit, const ControlCage& cage,
                   const Context& context, Json& figures, Outcome& outcome) {
  const ScopedStage stage(outcome.times, "step");
  const double diameter = bounding_box_diagonal(cage.mesh.positions);
  const BsplineSurface patches =
      joined_bsplines(limit_bsplines(cage, {}, context.progress), context.progress);
  StepOptions step;
  step.millimetres_per_unit = millimetres_in(unit);
  const std::string text = format_cad(cad_format_of(arguments.step), patches, step);
  write_file(arguments.step, text);
  Json& written = figures["step"];
  written["faces"] = patches.patches.size();
  written["edges"] = patches.edges.size();
  written["relative_deviation"] = patches.deviation / diameter;
  written["normal_jump_deg"] = degrees(patches.normal_jump);
  written["bytes"] = text.size();
  outcome.lines.push_back(concat(arguments.step, ": ", patches.patches.size(), " B-spline faces; within ",
                                 100 * patches.deviation / diameter,
                                 " % of the diameter, normals at smooth edges within ",
                                 degrees(patches.normal_jump), " degrees"));
}

/// What is made of the model beside the project: a mesh with its measures, a STEP file.
void make_surface(const SketchArguments& arguments, const PolylineMesh& model, const std::string& unit,
                  const Context& context, Outcome& outcome) {
  ModelSurfaceOptions options = model_surface_options(arguments.model_surface);
  options.with_mesh = !arguments.surface.empty();
  ModelSurface surface = model_surface(model, options, context.progress);
  outcome.times.add(surface.times);
  outcome.warnings.insert(outcome.warnings.end(), surface.warnings.begin(), surface.warnings.end());
  if (surface.division)
    outcome.lines.push_back(concat("base mesh: ", surface.division->n_quads, " quads and ",
                                   surface.division->n_triangles, " triangles, ", surface.division->n_divided,
                                   " faces divided"));
  Json& figures = outcome.figures["surface"] = figures_json(surface);
  if (!arguments.surface.empty()) {
    {
      const ScopedStage stage(outcome.times, "continuity");
      const ModelContinuity continuity =
          model_continuity(model, surface.mesh, options.diffusion.splits, context.progress);
      const double diameter = model.diameter();
      figures["continuity"] = continuity_json(continuity, diameter);
      if (continuity.smooth.n_samples > 0)
        outcome.lines.push_back(concat("across smooth curves the normal jumps by ",
                                       degrees(continuity.smooth.max_normal_jump), " degrees at most (c",
                                       continuity.worst_curve, "), by ",
                                       degrees(continuity.smooth.mean_normal_jump), " in the mean"));
    }
    if (surface.soundness->is_sound() || arguments.accept_flaws)
      write_surface(arguments, unit, std::move(surface.mesh), figures, outcome);
    else
      outcome.failure = concat(surface.soundness->sentence(), "; ", arguments.surface,
                               " is not written (--accept-flaws writes it all the same)");
  }
  if (!arguments.step.empty()) write_patches(arguments, unit, surface.cage, context, figures, outcome);
}

/// A project with its history, or a session played.
Document read_document(const SketchArguments& arguments, Context& context, Outcome& outcome) {
  if (input_extension(arguments.session) == "batten") {
    const ScopedStage stage(outcome.times, "read");
    ProjectFile file = read_project(arguments.session);
    outcome.warnings = std::move(file.warnings);
    outcome.figures["refused"] = Json::array();
    return std::move(file.document);
  }
  Session session;
  {
    const ScopedStage stage(outcome.times, "read");
    session = read_session(arguments.session);
  }
  const ScopedStage stage(outcome.times, "edits");
  Document document;
  play(session, arguments.session, document, context, outcome);
  return document;
}

Outcome run_sketch(const SketchArguments& arguments, Context& context) {
  if (file_extension(arguments.output) != "batten")
    throw UnknownExtension(arguments.output, "is no project by its extension; use .batten");
  if (!arguments.surface.empty()) mesh_format(arguments.surface);
  if (!arguments.step.empty()) {
    cad_format_of(arguments.step);
    require_step();
  }
  Outcome outcome;
  const Document document = read_document(arguments, context, outcome);
  const ObjectId shown = model_to_show(document, arguments.model);
  const PolylineMesh& mesh = document.model(shown);
  const std::string& unit = document.unit(shown);
  outcome.figures["unit"] = unit;
  describe(mesh, outcome.figures);
  {
    const ScopedStage stage(outcome.times, "write");
    write_project(arguments.output, document);
  }
  const SketchCounts counts = mesh.counts();
  outcome.lines.push_back(concat(arguments.output, ": ", counts.curves, " curves, ", counts.vertices,
                                 " vertices, ", counts.faces, " faces, ", counts.components, " component",
                                 counts.components == 1 ? "" : "s", ", ", counts.boundary_loops, " border",
                                 counts.boundary_loops == 1 ? "" : "s", ", genus ", counts.genus));
  if (!arguments.surface.empty() || !arguments.step.empty()) {
    try {
      make_surface(arguments, mesh, unit, context, outcome);
    } catch (const FileError&) {
      throw;
    } catch (const InvalidInput& error) {  // the model and what was refused of it are told all the same
      outcome.figures["surface"] = {{"error", error.what()}};
      outcome.refusal = error.what();
    }
  }
  const auto n_refused = outcome.figures["refused"].size();
  if (arguments.strict && n_refused > 0 && outcome.failure.empty())
    outcome.failure =
        concat(n_refused, " edit", n_refused == 1 ? " was" : "s were", " refused, the first in line ",
               outcome.figures["refused"][0]["line"].get<long>(), ": ",
               outcome.figures["refused"][0]["reason"].get<std::string>());
  return outcome;
}

}  // namespace

void add_sketch(CLI::App& app) {
  const auto arguments = std::make_shared<SketchArguments>();
  CLI::App* command =
      add_command(app, "sketch", "Play a recorded sketching session into a model of curves and faces.",
                  "batten sketch session.jsonl -o model.batten --json", [arguments, &app](Context& context) {
                    check_model_surface_arguments(*app.get_subcommand("sketch"), arguments->model_surface);
                    return run_sketch(*arguments, context);
                  });
  command->add_option("session", arguments->session, "Session (JSON lines), or a project (.batten)")
      ->required();
  command->add_option("-o,--output", arguments->output, "Project to write: .batten")->required();
  command->add_option("--surface", arguments->surface, "Surface to write: .ply, .obj, .off or .stl");
  add_model_surface_options(*command, arguments->model_surface);
  command->add_option("--step", arguments->step,
                      "STEP or IGES file to write: the limit surface as B-spline faces");
  command->add_option("--model", arguments->model, "Name of the model, where the project has several");
  command->add_flag("--strict", arguments->strict, "Exit with 1 when an edit was refused");
  command->add_flag("--accept-flaws", arguments->accept_flaws,
                    "Exit with 0 although the surface crosses itself or is turned over somewhere");
}

}  // namespace batten::cli
