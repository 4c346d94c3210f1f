#pragma once
#include "batten/session/request.hpp"

// Private to the room: the fields of every options struct, each named once for reading, writing and
// comparing. The structured bindings fail to compile when a struct gains a field that is not named here.
namespace batten::detail {

template <typename Visitor>
void visit_fields(ScanOptions& options, Visitor& visit) {
  // What the result is to tell beside the network is no part of a request: a project keeps no draws.
  [[maybe_unused]] auto& [step, weights, lambda, mu, energy, xi, robust, scheme, lengths, sigma,
                          uncertainty] = options;
  visit("step", step);
  visit("weights", weights);
  visit("lambda", lambda);
  visit("mu", mu);
  visit("energy", energy);
  visit("xi", xi);
  visit("robust", robust);
  visit("scheme", scheme);
  visit("lengths", lengths);
  visit("sigma", sigma);
}

template <typename Visitor>
void visit_fields(StrokeNetworkOptions& options, Visitor& visit) {
  auto& [weld_tolerance, reach, step] = options;
  visit("weld_tolerance", weld_tolerance);
  visit("reach", reach);
  visit("step", step);
}

template <typename Visitor>
void visit_fields(SurfaceOptions& options, Visitor& visit) {
  auto& [method, map, base_order, rebuilds, soft_constraints, soft_weight, edge_length, max_triangles] =
      options;
  visit("method", method);
  visit("map", map);
  visit("base_order", base_order);
  visit("rebuilds", rebuilds);
  visit("soft_constraints", soft_constraints);
  visit("soft_weight", soft_weight);
  visit("edge_length", edge_length);
  visit("max_triangles", max_triangles);
}

template <typename Visitor>
void visit_fields(NetworkSurfaceOptions& options, Visitor& visit) {
  auto& [surface, edge_length, flatten_crossings] = options;
  visit("surface", surface);
  visit("edge_length", edge_length);
  visit("flatten_crossings", flatten_crossings);
}

template <typename Visitor>
void visit_fields(DiffusionOptions& options, Visitor& visit) {
  auto& [splits, rounds, tolerance, time_step, diffusion_steps, similarity, fidelity, keep_folded] = options;
  visit("splits", splits);
  visit("rounds", rounds);
  visit("tolerance", tolerance);
  visit("time_step", time_step);
  visit("diffusion_steps", diffusion_steps);
  visit("similarity", similarity);
  visit("fidelity", fidelity);
}

template <typename Visitor>
void visit_fields(CoonsOptions& options, Visitor& visit) {
  auto& [search, steps, scheme, levels, through_curves] = options;
  visit("search", search);
  visit("steps", steps);
  visit("scheme", scheme);
  visit("levels", levels);
  visit("through_curves", through_curves);
}

template <typename Visitor>
void visit_fields(ModelSurfaceOptions& options, Visitor& visit) {
  auto& [method, diffusion, levels, coons, with_mesh] = options;
  visit("method", method);
  visit("diffusion", diffusion);
  visit("levels", levels);
  visit("coons", coons);
  visit("with_mesh", with_mesh);
}

template <typename Visitor>
void visit_fields(FairingOptions& options, Visitor& visit) {
  auto& [method, noise, iterations, keep_boundary] = options;
  visit("method", method);
  visit("noise", noise);
  visit("iterations", iterations);
  visit("keep_boundary", keep_boundary);
}

template <typename Visitor>
void visit_fields(RemeshOptions& options, Visitor& visit) {
  auto& [method, edge_length, n_vertices, adaptivity, keep_edges, hold_border, sizes, max_iterations,
         tolerance] = options;
  static_cast<void>(sizes);  // RemeshRequest names them instead
  visit("method", method);
  visit("edge_length", edge_length);
  visit("n_vertices", n_vertices);
  visit("adaptivity", adaptivity);
  visit("keep_edges", keep_edges);
  visit("hold_border", hold_border);
  visit("max_iterations", max_iterations);
  visit("tolerance", tolerance);
}

template <typename Visitor>
void visit_fields(PLaplacianOptions& options, Visitor& visit) {
  auto& [p, weight, fidelity, time_step, steps, epsilon, sigma] = options;
  visit("p", p);
  visit("weight", weight);
  visit("fidelity", fidelity);
  visit("time_step", time_step);
  visit("steps", steps);
  visit("epsilon", epsilon);
  visit("sigma", sigma);
}

template <typename Visitor>
void visit_fields(SimplifyOptions& options, Visitor& visit) {
  auto& [method, faces, remove, max_error, levels, keep_levels, keep_history, keep_edges, hold_border, alpha,
         beta, flow, fit_rounds] = options;
  visit("method", method);
  visit("faces", faces);
  visit("remove", remove);
  visit("max_error", max_error);
  visit("levels", levels);
  visit("keep_levels", keep_levels);
  visit("keep_history", keep_history);
  visit("keep_edges", keep_edges);
  visit("hold_border", hold_border);
  visit("alpha", alpha);
  visit("beta", beta);
  visit("flow", flow);
  visit("fit_rounds", fit_rounds);
}

template <typename Visitor>
void visit_fields(SubdivisionOptions& options, Visitor& visit) {
  auto& [scheme, levels, limit, smooth_corners, knot_exponent] = options;
  visit("scheme", scheme);
  visit("levels", levels);
  visit("limit", limit);
  visit("smooth_corners", smooth_corners);
  visit("knot_exponent", knot_exponent);
}

template <typename Visitor>
void visit_fields(DeformOptions& options, Visitor& visit) {
  auto& [energy, detail, soft_weight, bending_length, curvature_term, detail_weight, membrane_length,
         max_iterations, tolerance] = options;
  visit("energy", energy);
  visit("detail", detail);
  visit("soft_weight", soft_weight);
  visit("bending_length", bending_length);
  visit("curvature_term", curvature_term);
  visit("detail_weight", detail_weight);
  visit("membrane_length", membrane_length);
  visit("max_iterations", max_iterations);
  visit("tolerance", tolerance);
}

template <typename Visitor>
void visit_fields(Length& length, Visitor& visit) {
  auto& [value, kind] = length;
  visit("value", value);
  visit("kind", kind);
}

template <typename Visitor>
void visit_fields(MovedVertices& moved, Visitor& visit) {
  auto& [vertices, translation, axis, angle, about, targets] = moved;
  visit("vertices", vertices);
  visit("translation", translation);
  visit("axis", axis);
  visit("angle", angle);
  visit("about", about);
  visit("targets", targets);
}

template <typename Visitor>
void visit_fields(NetworkRequest& request, Visitor& visit) {
  visit_fields(request.options, visit);
}
template <typename Visitor>
void visit_fields(SurfaceRequest& request, Visitor& visit) {
  visit("strokes", request.strokes);
  visit("surface", request.surface);
}
template <typename Visitor>
void visit_fields(ModelSurfaceRequest& request, Visitor& visit) {
  visit_fields(request.options, visit);
}
template <typename Visitor>
void visit_fields(FairRequest& request, Visitor& visit) {
  visit_fields(request.options, visit);
}
template <typename Visitor>
void visit_fields(RemeshRequest& request, Visitor& visit) {
  visit_fields(request.options.remesh, visit);
  visit("length", request.options.edge_length);
  visit("sizes", request.sizes);
}
template <typename Visitor>
void visit_fields(SimplifyRequest& request, Visitor& visit) {
  visit_fields(request.options.simplify, visit);
  visit("error", request.options.max_error);
}
template <typename Visitor>
void visit_fields(SubdivideRequest& request, Visitor& visit) {
  auto& [first_schemes, subdivision, refine, patches] = request.options;
  static_cast<void>(refine);   // a result without a mesh would be none
  static_cast<void>(patches);  // of files, not of objects
  visit("first_schemes", first_schemes);
  visit_fields(subdivision, visit);
}
template <typename Visitor>
void visit_fields(DeformRequest& request, Visitor& visit) {
  visit_fields(request.options.deform, visit);
  visit("multiresolution", request.options.multiresolution);
  visit("fixed", request.fixed);
  visit("moved", request.moved);
}
template <typename Visitor>
void visit_fields(RepairRequest& request, Visitor& visit) {
  auto& [weld, weld_length, orient, fill_holes] = request.options;
  visit("weld", weld);
  visit("weld_length", weld_length);
  visit("orient", orient);
  visit("fill_holes", fill_holes);
}

}  // namespace batten::detail
