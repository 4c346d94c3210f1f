#pragma once
#include "commands/check.hpp"
#include "commands/compare.hpp"
#include "commands/deform.hpp"
#include "commands/fair.hpp"
#include "commands/network.hpp"
#include "commands/remesh.hpp"
#include "commands/repair.hpp"
#include "commands/simplify.hpp"
#include "commands/simulate.hpp"
#include "commands/subdivide.hpp"
#include "commands/surface.hpp"

#include <cmath>
#include <cstdint>
#include <string>
#include <type_traits>

#include <pybind11/pybind11.h>

namespace batten::python {

// The options of every command, by the names that they have on the command line: each_option() calls
// visit(name, field) for all.

template <typename Visit>
void each_option(commands::FairArguments& a, const Visit& visit) {
  visit("method", a.method);
  visit("noise", a.noise);
  visit("iterations", a.iterations);
  visit("keep_boundary", a.keep_boundary);
  visit("repair", a.repair);
}

template <typename Visit>
void each_option(commands::RemeshArguments& a, const Visit& visit) {
  visit("edge", a.edge);
  visit("vertices", a.vertices);
  visit("adaptivity", a.adaptivity);
  visit("keep_edges", a.keep_edges);
  visit("keep_border", a.keep_border);
  visit("method", a.method);
  visit("sizes", a.sizes);
  visit("iterations", a.iterations);
  visit("repair", a.repair);
  visit("accept_flaws", a.accept_flaws);
}

template <typename Visit>
void each_option(commands::RepairArguments& a, const Visit& visit) {
  visit("weld", a.weld);
  visit("orient", a.orient);
  visit("fill_holes", a.fill_holes);
  visit("accept_flaws", a.accept_flaws);
}

template <typename Visit>
void each_option(commands::SimplifyArguments& a, const Visit& visit) {
  visit("faces", a.faces);
  visit("remove", a.remove);
  visit("error", a.error);
  visit("levels", a.levels);
  visit("method", a.method);
  visit("keep_edges", a.keep_edges);
  visit("keep_border", a.keep_border);
  visit("p", a.p);
  visit("alpha", a.alpha);
  visit("beta", a.beta);
  visit("weight", a.weight);
  visit("sigma", a.sigma);
  visit("fidelity", a.fidelity);
  visit("keep_all_levels", a.keep_all_levels);
  visit("repair", a.repair);
}

template <typename Visit>
void each_option(commands::DeformArguments& a, const Visit& visit) {
  visit("energy", a.energy);
  visit("nonlinear", a.nonlinear);
  visit("soft", a.soft);
  visit("multiresolution", a.multiresolution);
  visit("iterations", a.iterations);
  visit("repair", a.repair);
}

template <typename Visit>
void each_option(commands::SubdivideArguments& a, const Visit& visit) {
  visit("scheme", a.scheme);
  visit("levels", a.levels);
  visit("limit", a.limit);
  visit("corners", a.corners);
  visit("knots", a.knots);
}

template <typename Visit>
void each_option(commands::CompareArguments& a, const Visit& visit) {
  visit("register", a.registration);
  visit("samples", a.samples);
  visit("seed", a.seed);
  visit("repair", a.repair);
}

template <typename Visit>
void each_option(commands::CheckArguments& a, const Visit& visit) {
  visit("continuity", a.continuity);
  visit("tolerance", a.tolerance);
  visit("gap", a.gap);
  visit("curvature", a.curvature);
  visit("distance", a.distance);
}

/// How the surface is made, without what comes before and after.
template <typename Visit>
void each_surface_option(commands::SurfaceArguments& a, const Visit& visit) {
  visit("rebuilds", a.rebuilds);
  visit("method", a.method);
  visit("constraints", a.constraints);
  visit("soft_weight", a.soft_weight);
  visit("map", a.map);
  visit("base_order", a.base_order);
  visit("edge_length", a.edge_length);
  visit("max_triangles", a.max_triangles);
}

template <typename Visit>
void each_option(commands::NetworkArguments& a, const Visit& visit) {
  visit("step", a.step);
  visit("weights", a.weights);
  visit("energy", a.energy);
  visit("xi", a.xi);
  visit("robust", a.robust);
  visit("scheme", a.scheme);
  visit("uncertainty", a.uncertainty);
  visit("nodes", a.nodes);
  visit("lengths", a.lengths);
}

struct FillArguments {
  commands::SurfaceArguments surface;
  commands::StrokeArguments strokes;
  bool uncertainty = false;
};
template <typename Visit>
void each_option(FillArguments& a, const Visit& visit) {
  each_surface_option(a.surface, visit);
  visit("accept_flaws", a.surface.accept_flaws);
  visit("weld", a.strokes.weld);
  visit("reach", a.strokes.reach);
  visit("step", a.strokes.step);
  visit("topology", a.strokes.topology);
  visit("closed", a.strokes.closed);
  visit("symmetry", a.strokes.symmetry);
  visit("crossings", a.surface.crossings);
  visit("uncertainty", a.uncertainty);
}

/// Of a kept solver.
struct KeptArguments {
  commands::SurfaceArguments surface;
};
template <typename Visit>
void each_option(KeptArguments& a, const Visit& visit) {
  each_surface_option(a.surface, visit);
}

struct ReconstructArguments {
  commands::NetworkArguments network;
  commands::SurfaceArguments surface;
};
template <typename Visit>
void each_option(ReconstructArguments& a, const Visit& visit) {
  each_surface_option(a.surface, visit);
  visit("accept_flaws", a.surface.accept_flaws);
  each_option(a.network, visit);
}

template <typename Visit>
void each_option(commands::SimulateArguments& a, const Visit& visit) {
  visit("seed", a.seed);
  visit("step", a.step);
  visit("jitter", a.jitter);
  visit("dwell", a.dwell);
  visit("orientation_noise", a.orientation_noise);
  visit("drift", a.drift);
  visit("drift_length", a.drift_length);
  visit("odometer_error", a.odometer_error);
  visit("outliers", a.outliers);
  visit("disturbance", a.disturbance);
  visit("curve_length_error", a.curve_length_error);
  visit("speed_variation", a.speed_variation);
  visit("nodes", a.nodes);
  visit("raw", a.raw);
  visit("sensor_noise", a.sensor_noise);
  visit("distortion", a.distortion);
  visit("gyroscope", a.gyroscope);
  visit("gyroscope_rate", a.gyroscope_rate);
  visit("gyroscope_bias", a.gyroscope_bias);
  visit("gyroscope_walk", a.gyroscope_walk);
  visit("gyroscope_scale", a.gyroscope_scale);
  visit("gyroscope_misalignment", a.gyroscope_misalignment);
  visit("gyroscope_temperature", a.gyroscope_temperature);
  visit("gyroscope_warming", a.gyroscope_warming);
  visit("planes", a.planes);
  visit("axes", a.axes);
  visit("truth_step", a.truth_step);
  visit("truth_edge", a.truth_edge);
}

// One option: text takes words, numbers (an exact decimal), None (empty) and lists of these (joined by
// commas); numbers and switches take what they are. @throws InvalidInput naming the option.

void read_option(const std::string& name, pybind11::handle given, std::string& field);
void read_option(const std::string& name, pybind11::handle given, double& field);
void read_option(const std::string& name, pybind11::handle given, bool& field);
/// A whole number from `least` to `most`.
long long whole_number(const std::string& name, pybind11::handle given, long long least,
                       unsigned long long most);

template <typename Integer,
          typename = std::enable_if_t<std::is_integral_v<Integer> && !std::is_same_v<Integer, bool>>>
void read_option(const std::string& name, pybind11::handle given, Integer& field) {
  field = static_cast<Integer>(whole_number(name, given,
                                            static_cast<long long>(std::numeric_limits<Integer>::min()),
                                            std::numeric_limits<Integer>::max()));
}

/// The options of a call. @throws InvalidInput as read_option(). @pre every name is one of the arguments.
template <typename Arguments>
Arguments options_from(const pybind11::dict& given) {
  Arguments arguments;
  each_option(arguments, [&](const char* name, auto& field) {
    if (given.contains(name)) read_option(name, given[name], field);
  });
  return arguments;
}

template <typename Arguments>
pybind11::dict default_options() {
  Arguments arguments;
  pybind11::dict defaults;
  each_option(arguments, [&](const char* name, const auto& field) {
    if constexpr (std::is_same_v<std::decay_t<decltype(field)>, std::string>)
      defaults[name] =
          field.empty() ? pybind11::object(pybind11::none()) : pybind11::object(pybind11::str(field));
    else
      defaults[name] = pybind11::cast(field);
  });
  return defaults;
}

/// Adds default_options(command), by which tests hold the signatures against the program.
void add_options(pybind11::module_& module);

}  // namespace batten::python
