#pragma once
#include <compare>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "batten/core/choices.hpp"
#include "batten/core/units.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/network/curve_network.hpp"
#include "batten/scan/calibration.hpp"
#include "batten/scan/scan.hpp"
#include "batten/session/request.hpp"
#include "batten/sketch/polyline_mesh.hpp"

namespace batten {

/// The number of an object in its project, from 1; "o3" in journals. 0 is none.
struct ObjectId {
  int number = 0;
  auto operator<=>(const ObjectId&) const = default;
};

/// The axis that points up on the screen.
enum class UpAxis { X, Y, Z };
constexpr auto choices_of(UpAxis) {
  return choices<UpAxis>("axis", {{UpAxis::X, "x"}, {UpAxis::Y, "y"}, {UpAxis::Z, "z"}});
}

/// What a view shows on surfaces.
enum class ViewShading {
  Shaded,
  Isophotes,
  ReflectionLines,
  Normals,
  MeanCurvature,
  GaussianCurvature,
  Deviation,  ///< standard deviation of the surface, from the noise of the readings
  Error,      ///< distance to a truth
};
constexpr auto choices_of(ViewShading) {
  return choices<ViewShading>("shading of the view", {{ViewShading::Shaded, "shaded"},
                                                      {ViewShading::Isophotes, "isophotes"},
                                                      {ViewShading::ReflectionLines, "reflection-lines"},
                                                      {ViewShading::Normals, "normals"},
                                                      {ViewShading::MeanCurvature, "mean-curvature"},
                                                      {ViewShading::GaussianCurvature, "gaussian-curvature"},
                                                      {ViewShading::Deviation, "deviation"},
                                                      {ViewShading::Error, "error"}});
}

/// A view of the project: from where, and what is shown.
struct ViewState {
  double azimuth = radians(-55.0);   ///< of the viewer, radians about the up axis
  double elevation = radians(28.0);  ///< of the viewer above the horizon, −π/2 … π/2
  UpAxis up = UpAxis::Z;
  bool perspective = true;
  double zoom = 1;                        ///< enlarges about the target, above 0; 1 shows everything
  std::optional<Eigen::Vector3d> target;  ///< in the middle of the picture; nothing: of what is shown
  ViewShading shading = ViewShading::Shaded;
  std::vector<ObjectId> hidden;
};

using SharedScan = std::shared_ptr<const Scan>;
using SharedNetwork = std::shared_ptr<const CurveNetwork>;
using SharedModel = std::shared_ptr<const PolylineMesh>;
using SharedMesh = std::shared_ptr<const TriangleMesh>;

/// What an object holds, in the order of ObjectKind. Shared and never changed: undo keeps old contents by
/// keeping the pointer.
using Content = std::variant<SharedScan, SharedNetwork, SharedModel, SharedMesh, Calibration, ViewState>;
ObjectKind kind_of(const Content& content);

/// An object that is made of another one. What it is made into is not part of the project: see
/// Document::version().
struct Derived {
  ObjectId source;
  std::shared_ptr<const Request> request;  ///< never null
};

/// One object of a project.
struct Object {
  std::string name;
  /// Of its lengths ("m", "mm", …), or empty: not known. Empty for derived objects, whose lengths are those
  /// of what they are made of: see Document::unit(). The units written in a Scan or CurveNetwork are not
  /// looked at.
  std::string unit;
  /// A model is null here: its curves and faces are Document::model().
  std::variant<Content, Derived> body;

  /// What the object is, or is made into.
  ObjectKind kind() const;
  const Derived* derived() const { return std::get_if<Derived>(&body); }
  const Content* content() const { return std::get_if<Content>(&body); }
};

/// The first problem that keeps a content out of a project, or nothing: no content, text that is not UTF-8,
/// arrays that do not fit each other, numbers of a view out of range.
std::optional<std::string> problem(const Content& content);

/// The same of one curve of a scan; `index` names it.
std::optional<std::string> problem(const ScanCurve& curve, std::size_t index);

/// Equal in everything, numbers bit for bit.
bool same_content(const Content& a, const Content& b);
bool operator==(const Object& a, const Object& b);

}  // namespace batten
