#pragma once
#include <optional>
#include <string>

#include <pybind11/pybind11.h>

#include "batten/io/mesh_attributes.hpp"
#include "batten/mesh/control_cage.hpp"
#include "batten/mesh/shape.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/scan/scan.hpp"
#include "batten/scan/sensor_log.hpp"

namespace batten::python {

// The classes of the package hold arrays; here these are checked and copied into the structs of the library,
// and back without copies. To Python goes what the class is made of: a dict of its fields. All *_from() throw
// InvalidInput.

/// What a file says of a mesh beyond what Python shows of it; carried from reading to writing.
struct Attributes {
  MeshAttributes kept;
};

/// A mesh with the name that sentences call it.
struct NamedMesh {
  MeshFile file;
  std::string name;
};
NamedMesh mesh_from(pybind11::handle mesh);
pybind11::dict fields_of(MeshFile&& file);

/// A network, and how sure its vertices are: none or one for each.
struct KnownNetwork {
  CurveNetwork network;
  Eigen::VectorXd uncertainty;
};
KnownNetwork network_from(pybind11::handle network);
pybind11::dict fields_of(CurveNetwork&& network);

Scan scan_from(pybind11::handle scan);
pybind11::dict fields_of(Scan&& scan);

SensorLog log_from(pybind11::handle log);
pybind11::dict fields_of(SensorLog&& log);

ControlCage cage_from(pybind11::handle cage);
pybind11::dict fields_of(ControlCage&& cage);

/// A mesh or a network: whichever it is by its class.
bool is_mesh(pybind11::handle object);

void add_objects(pybind11::module_& module);

}  // namespace batten::python
