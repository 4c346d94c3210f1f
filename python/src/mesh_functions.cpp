#include "arrays.hpp"
#include "commands/mesh_file.hpp"
#include "errors.hpp"
#include "functions.hpp"
#include "objects.hpp"
#include "options.hpp"
#include "reports.hpp"
#include "running.hpp"

#include <memory>
#include <utility>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/handles_io.hpp"
#include "batten/pipeline/carried_values.hpp"
#include "batten/pipeline/mesh_input.hpp"

namespace batten::python {

namespace {

/// A result, the input it was made of, and what was told on the way.
template <typename Result>
struct Made {
  MeshFile file;  ///< what Python gets
  Result result;
  MeshFile input;
  std::vector<std::string> warnings;
};

/// Reads a mesh as every command on meshes does.
void prepare(NamedMesh& mesh, std::vector<std::string>& warnings, bool repair, const Progress& progress) {
  commands::prepare_mesh(mesh.name, mesh.file, warnings, repair, progress);
}

template <typename Result>
void add_warnings(const std::vector<std::string>& more, Made<Result>& made) {
  made.warnings.insert(made.warnings.end(), more.begin(), more.end());
}

py::dict fair(const py::object& mesh, const py::dict& given, const py::object& progress) {
  const auto arguments = options_from<commands::FairArguments>(given);
  const FairingOptions options = options_of(arguments);
  auto made = running(progress, [input = mesh_from(mesh), arguments, options](const Progress& p) mutable {
    Made<FairedMesh> out;
    prepare(input, out.warnings, arguments.repair, p);
    out.result = faired_mesh(input.file.mesh, options, p);
    add_warnings(out.result.warnings, out);
    out.file = commands::made_file(out.result.mesh, input.file, true, out.warnings, p);
    return out;
  });
  py::dict fields = fields_of(std::move(made.file));
  fields["report"] = report_of("fair", commands::figures_of(arguments, made.result), given, made.result.times,
                               made.warnings);
  return fields;
}

py::dict remesh(const py::object& mesh, const py::object& sizes, const py::dict& given,
                const py::object& progress) {
  const auto arguments = options_from<commands::RemeshArguments>(given);
  NamedMesh read = mesh_from(mesh);
  // Words are refused before the work; the name of values is looked up where the mesh is known to be sound.
  Eigen::VectorXd wanted;
  if (!sizes.is_none()) wanted = numbers_from(sizes, read.file.mesh.n_vertices(), "sizes");
  options_of(arguments, read.file.mesh, read.name);
  auto made = running(progress, [input = std::move(read), wanted, arguments](const Progress& p) mutable {
    Made<RemeshedMesh> out;
    const Eigen::Index n = input.file.mesh.n_vertices();
    prepare(input, out.warnings, arguments.repair, p);
    RemeshedMeshOptions options = options_of(arguments, input.file.mesh, input.name);
    if (wanted.size() > 0 && input.file.mesh.n_vertices() != n)
      throw InvalidInput("sizes are of the vertices before the mesh was welded or repaired; repair it first");
    if (wanted.size() > 0) options.remesh.sizes = wanted;
    out.result = remeshed_mesh(input.file.mesh, options, p);
    add_warnings(out.result.warnings, out);
    tell_flaws(out.result.flaws, concat("the new triangles do not stand for ", input.name),
               arguments.accept_flaws, out.warnings);
    out.file = commands::made_file(out.result.mesh, input.file, false, out.warnings, p);
    return out;
  });
  py::dict fields = fields_of(std::move(made.file));
  fields["report"] =
      report_of("remesh", commands::figures_of(made.result), given, made.result.times, made.warnings);
  return fields;
}

py::dict repair(const py::object& mesh, const py::dict& given, const py::object& progress) {
  const auto arguments = options_from<commands::RepairArguments>(given);
  const RepairedMeshOptions options = options_of(arguments);
  auto made = running(progress, [input = mesh_from(mesh), arguments, options](const Progress& p) {
    Made<RepairedMesh> out;
    try {
      out.result = repaired_mesh(input.file.mesh, options, p);
    } catch (const InvalidInput& problem) {
      throw InvalidInput(concat(input.name, ": ", problem.what()));
    }
    add_warnings(out.result.warnings, out);
    tell_flaws(out.result.flaws, concat("not all of ", input.name, " could be repaired"),
               arguments.accept_flaws, out.warnings);
    out.file = commands::made_file(out.result.mesh, input.file, false, out.warnings, p);
    out.input.mesh = input.file.mesh;
    return out;
  });
  py::dict fields = fields_of(std::move(made.file));
  fields["report"] = report_of("repair", commands::figures_of(made.input.mesh, made.result), given,
                               made.result.times, made.warnings);
  fields["done"] = made.result.done;
  return fields;
}

py::dict simplify(const py::object& mesh, const py::dict& given, const py::object& progress) {
  const auto arguments = options_from<commands::SimplifyArguments>(given);
  const SimplifiedMeshOptions options = options_of(arguments);
  auto made = running(progress, [input = mesh_from(mesh), arguments, options](const Progress& p) mutable {
    Made<SimplifiedMesh> out;
    prepare(input, out.warnings, arguments.repair, p);
    out.result = simplified_mesh(input.file.mesh, options, p);
    add_warnings(out.result.warnings, out);
    out.file = commands::made_file(out.result.simplified.mesh, input.file, false, out.warnings, p);
    out.input = std::move(input.file);
    return out;
  });
  commands::Json figures = commands::Json::object();
  py::list levels;
  if (options.simplify.keep_levels) {
    commands::Json counts = commands::Json::array();
    for (TriangleMesh& level : level_meshes(made.input.mesh, made.result.simplified.levels)) {
      counts.push_back({{"vertices", level.n_vertices()}, {"faces", level.n_triangles()}});
      levels.append(fields_of(MeshFile{std::move(level), {}}));
    }
    figures["levels"] = counts;
  }
  commands::append(commands::figures_of(made.input.mesh, made.result), figures);
  py::dict fields = fields_of(std::move(made.file));
  fields["report"] = report_of("simplify", figures, given, made.result.times, made.warnings);
  fields["vertex_map"] = owned(std::move(made.result.simplified.vertex_map));
  fields["levels"] = levels;
  return fields;
}

py::dict deform(const py::object& mesh, const std::string& handles, const py::dict& given,
                const py::object& progress) {
  const auto arguments = options_from<commands::DeformArguments>(given);
  const DeformedMeshOptions options = options_of(arguments);
  auto made =
      running(progress, [input = mesh_from(mesh), handles, arguments, options](const Progress& p) mutable {
        Made<DeformedMesh> out;
        prepare(input, out.warnings, arguments.repair, p);
        Handles read;
        try {
          read = parse_handles(handles, "handles", input.file.mesh.positions);
        } catch (const FileError& problem) {
          throw InvalidInput(problem.what());  // there is no file
        }
        out.result = deformed_mesh(input.file.mesh, read, options, p);
        add_warnings(out.result.warnings, out);
        out.file = commands::made_file(out.result.mesh, input.file, true, out.warnings, p);
        return out;
      });
  py::dict fields = fields_of(std::move(made.file));
  fields["report"] =
      report_of("deform", commands::figures_of(made.result), given, made.result.times, made.warnings);
  return fields;
}

py::dict subdivide(const py::object& cage, const py::dict& given, const py::object& progress) {
  const auto arguments = options_from<commands::SubdivideArguments>(given);
  const SubdividedCageOptions options = options_of(arguments);
  SubdividedCage made = running(progress, [input = cage_from(cage), options](const Progress& p) {
    return subdivided_cage(input, options, p);
  });
  const py::dict report =
      report_of("subdivide", commands::figures_of(made), given, made.times, made.warnings);
  py::dict fields = fields_of(std::move(made.refined->cage));
  fields["normals"] = owned_or_none(std::move(made.refined->normals));
  fields["triangles"] = owned(std::move(made.refined->triangles.triangles));
  fields["report"] = report;
  return fields;
}

/// A mesh or a network that is measured.
struct Measured {
  std::string name;
  std::optional<NamedMesh> mesh;
  std::optional<CurveNetwork> network;

  Shape shape() const { return mesh ? shape_of(mesh->file.mesh) : shape_of(*network); }
  commands::Json described() const {
    commands::Json json = {{"kind", mesh ? "mesh" : "network"},
                           {"vertices", mesh ? mesh->file.mesh.n_vertices() : network->positions.rows()}};
    if (mesh)
      json["faces"] = mesh->file.mesh.n_triangles();
    else
      json["curves"] = network->curves.size();
    return json;
  }
};

Measured measured_from(const py::object& object, const char* name) {
  try {
    Measured measured;
    if (is_mesh(object))
      measured.mesh = mesh_from(object);
    else
      measured.network = network_from(object).network;
    return measured;
  } catch (const InvalidInput& problem) {
    throw InvalidInput(concat(name, ": ", problem.what()));
  }
}

py::dict compare(const py::object& a, const py::object& b, const py::dict& given,
                 const py::object& progress) {
  const auto arguments = options_from<commands::CompareArguments>(given);
  const CompareOptions options = options_of(arguments);
  struct Compared {
    Measured a, b;
    ShapeComparison result;
    std::vector<std::string> warnings;
  };
  Compared made = running(progress, [shapes = std::pair(measured_from(a, "A"), measured_from(b, "B")),
                                     arguments, options](const Progress& p) mutable {
    Compared out{std::move(shapes.first), std::move(shapes.second), {}, {}};
    if (arguments.repair)
      for (Measured* shape : {&out.a, &out.b})
        if (shape->mesh) commands::prepare_mesh(shape->mesh->name, shape->mesh->file, out.warnings, true, p);
    out.result = compared_shapes(out.a.shape(), out.b.shape(), options, p);
    out.warnings.insert(out.warnings.end(), out.result.warnings.begin(), out.result.warnings.end());
    return out;
  });
  commands::Json figures = commands::Json::object();
  figures["a"] = made.a.described();
  figures["b"] = made.b.described();
  commands::append(commands::figures_of(arguments, made.result), figures);
  py::dict fields;
  fields["report"] = report_of("compare", figures, given, made.result.times, made.warnings);
  fields["hausdorff"] = made.result.hausdorff;
  if (made.a.mesh) {
    MeshFile moved{measured_mesh(made.a.mesh->file.mesh, made.result.distances),
                   made.a.mesh->file.attributes};
    fields["mesh"] = fields_of(std::move(moved));
  } else {
    fields["mesh"] = py::none();
  }
  fields["distances"] = owned(std::move(made.result.distances.a_to_b.vertex_distances));
  return fields;
}

py::dict check(const py::object& surface, const py::object& network, const py::dict& given,
               const py::object& progress) {
  const auto arguments = options_from<commands::CheckArguments>(given);
  const CurveCheckOptions options = options_of(arguments);
  const Measured on = measured_from(surface, "surface"), along = measured_from(network, "network");
  if (!on.mesh) throw InvalidInput("surface: this is a network; surface() makes the surface to check");
  if (!along.network) throw InvalidInput("network: this is a mesh; the curves to check it along are wanted");
  const CurveCheck made = running(progress, [&](const Progress& p) {
    return check_curves(on.mesh->file.mesh, *along.network, options, p);
  });
  commands::Json figures = commands::Json::object();
  figures["surface"] = on.described();
  figures["network"] = along.described();
  commands::append(commands::figures_of(made), figures);
  py::dict fields;
  fields["report"] = report_of("check", figures, given, made.times, {});
  return fields;
}

py::dict carry(const py::object& from, const py::object& to, const py::object& progress) {
  MeshFile made = running(progress, [a = mesh_from(from), b = mesh_from(to)](const Progress& p) mutable {
    for (const NamedMesh* mesh : {&a, &b})
      if (const auto problem = mesh_problem(mesh->file.mesh))
        throw InvalidInput(concat(mesh->name, ": ", *problem));
    carry_values(a.file.mesh, b.file.mesh, p);
    return std::move(b.file);
  });
  return fields_of(std::move(made));
}

}  // namespace

void add_mesh_functions(py::module_& module) {
  module.def("fair", fair);
  module.def("remesh", remesh);
  module.def("repair", repair);
  module.def("simplify", simplify);
  module.def("deform", deform);
  module.def("subdivide", subdivide);
  module.def("compare", compare);
  module.def("check", check);
  module.def("carry_values", carry);
}

}  // namespace batten::python
