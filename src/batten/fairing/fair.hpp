#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"
#include "batten/linalg/iterative.hpp"

namespace batten {

/// The methods of `batten fair`.
enum class FairingMethod {
  Automatic,                 ///< fair_automatically(): the default, for every mesh
  NonlocalSurfaceDiffusion,  ///< nlsdf: the thesis's own, H section 2.1.5
  SurfaceDiffusion,          ///< sdf: the same without similarity weights
  MeanCurvature,             ///< mcf: fast, rounds everything and shrinks
  BiLaplacian,               ///< bilaplacian: shrinks less, rounds edges
  Anisotropic,               ///< amcf: slower where the surface is curved
  AnisotropicTensor,         ///< amcf-tensor: along edges only
  TotalVariation,            ///< tv: normals by total variation, then a refit
  Taubin,                    ///< taubin: low-pass filter, hardly shrinks
  BilateralNormal,           ///< bilateral-normal: [zheng2011]
  GuidedNormal,              ///< guided-normal: [zhang2015]
  Elastica,                  ///< elastica: Willmore flow
  Nonlocal,                  ///< nonlocal: positions with similarity weights
};

/// The names on the command line, in the order of FairingMethod.
const std::vector<std::string>& fairing_method_names();
/// @throws InvalidInput listing the names when `name` is none of them.
FairingMethod parse_fairing_method(std::string_view name);

/// Options of fair().
struct FairingOptions {
  FairingMethod method = FairingMethod::Automatic;
  /// Standard deviation of the noise in mean edge lengths; negative: estimated. The automatic method and the
  /// defaults of `iterations` of the others depend on it.
  double noise = -1;
  int iterations = 0;  ///< 0 takes the method's own number
  bool keep_boundary = false;
};

/// What fair() did.
struct FairingResult {
  Points positions;         ///< n × 3, in the order of the input
  double noise = 0;         ///< in mean edge lengths, given or estimated
  std::string strategy;     ///< of the automatic method: "sharp", "organic", "none"; else the method's name
  int iterations = 0;       ///< rounds or steps taken
  double time_step = 0;     ///< of the flows, else 0
  double largest_move = 0;  ///< in the unit of the mesh
  SolveQuality solves;      ///< the iterative ones; zeros for methods without
};

/// Removes noise from a mesh by any of the methods with its thesis or published parameters.
/// @throws InvalidInput, SolverFailure, Cancelled as the methods do.
FairingResult fair(const Points& positions, const Triangles& triangles, const FairingOptions& options = {},
                   const Progress& progress = {});

}  // namespace batten
