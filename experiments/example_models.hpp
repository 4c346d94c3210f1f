#pragma once
#include <functional>
#include <string>
#include <vector>

#include "batten/sketch/polyline_mesh.hpp"

namespace batten::experiments {

/// A sketched model of a surface that a formula knows.
struct ExampleModel {
  std::string name;
  PolylineMesh model;
  /// Distance of a point from the surface, in the unit of the model; for the ellipsoid to first order.
  std::function<double(const Eigen::Vector3d&)> truth;
};

/// The names in order: sphere (three great circles, H fig. 7.7), ellipsoid (its three principal sections),
/// cylinder (open), torus (genus 1), box (all twelve edges sharp).
const std::vector<std::string>& example_model_names();

/// Draws one with the tools of sketch/tools.hpp, from exact strokes. @pre one of the names.
ExampleModel example_model(const std::string& name);

}  // namespace batten::experiments
