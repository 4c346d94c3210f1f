#pragma once
#include <optional>
#include <string>

#include "batten/core/arrays.hpp"
#include "batten/core/choices.hpp"
#include "batten/core/progress.hpp"
#include "batten/fairing/automatic.hpp"
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

constexpr auto choices_of(FairingMethod) {
  return choices<FairingMethod>("fairing method", {{FairingMethod::Automatic, "auto"},
                                                   {FairingMethod::NonlocalSurfaceDiffusion, "nlsdf"},
                                                   {FairingMethod::SurfaceDiffusion, "sdf"},
                                                   {FairingMethod::MeanCurvature, "mcf"},
                                                   {FairingMethod::BiLaplacian, "bilaplacian"},
                                                   {FairingMethod::Anisotropic, "amcf"},
                                                   {FairingMethod::AnisotropicTensor, "amcf-tensor"},
                                                   {FairingMethod::TotalVariation, "tv"},
                                                   {FairingMethod::Taubin, "taubin"},
                                                   {FairingMethod::BilateralNormal, "bilateral-normal"},
                                                   {FairingMethod::GuidedNormal, "guided-normal"},
                                                   {FairingMethod::Elastica, "elastica"},
                                                   {FairingMethod::Nonlocal, "nonlocal"}});
}

/// Options of fair().
struct FairingOptions {
  FairingMethod method = FairingMethod::Automatic;
  /// Standard deviation of the noise in mean edge lengths; negative: estimated. The automatic method and the
  /// defaults of `iterations` of the others depend on it.
  double noise = -1;
  int iterations = 0;  ///< 0 takes the method's own number
  bool keep_boundary = false;

  /// The first problem found, naming field and value, or nothing.
  std::optional<std::string> problem() const;
};

/// What fair() did.
struct FairingResult {
  Points positions;                         ///< n × 3, in the order of the input
  double noise = 0;                         ///< in mean edge lengths, given or estimated
  std::optional<FairingStrategy> strategy;  ///< of the automatic method alone
  int iterations = 0;                       ///< rounds or steps taken
  double time_step = 0;                     ///< of the flows, else 0
  double largest_move = 0;                  ///< in the unit of the mesh
  SolveQuality solves;                      ///< the iterative ones; zeros for methods without
};

/// Removes noise from a mesh by any of the methods with its thesis or published parameters.
/// @throws InvalidInput, SolverFailure, Cancelled as the methods do.
FairingResult fair(const Points& positions, const Triangles& triangles, const FairingOptions& options = {},
                   const Progress& progress = {});

}  // namespace batten
