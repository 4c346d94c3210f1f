#pragma once
#include "batten/core/choices.hpp"
#include "batten/session/request.hpp"

// Private to the room: words in journals for enumerations that have none beside them.
namespace batten {

constexpr auto journal_choices_of(Length::Kind) {
  return choices<Length::Kind>("kind of length", {{Length::Kind::Plain, "plain"},
                                                  {Length::Kind::Metres, "metres"},
                                                  {Length::Kind::Relative, "relative"}});
}
constexpr auto journal_choices_of(WeightChoice) {
  return choices<WeightChoice>(
      "choice of weights",
      {{WeightChoice::Auto, "auto"}, {WeightChoice::Thesis, "thesis"}, {WeightChoice::Given, "given"}});
}
constexpr auto journal_choices_of(FairingMethod) {
  using enum FairingMethod;
  return choices<FairingMethod>("fairing method", {{Automatic, "auto"},
                                                   {NonlocalSurfaceDiffusion, "nlsdf"},
                                                   {SurfaceDiffusion, "sdf"},
                                                   {MeanCurvature, "mcf"},
                                                   {BiLaplacian, "bilaplacian"},
                                                   {Anisotropic, "amcf"},
                                                   {AnisotropicTensor, "amcf-tensor"},
                                                   {TotalVariation, "tv"},
                                                   {Taubin, "taubin"},
                                                   {BilateralNormal, "bilateral-normal"},
                                                   {GuidedNormal, "guided-normal"},
                                                   {Elastica, "elastica"},
                                                   {Nonlocal, "nonlocal"}});
}
constexpr auto journal_choices_of(RemeshMethod) {
  return choices<RemeshMethod>("remeshing method",
                               {{RemeshMethod::Adaptive, "ar"}, {RemeshMethod::LaplacianFlow, "lf"}});
}
constexpr auto journal_choices_of(FlowWeight) {
  return choices<FlowWeight>(
      "weight of the flow",
      {{FlowWeight::Uniform, "w1"}, {FlowWeight::InverseLength, "w2"}, {FlowWeight::Curvature, "w3"}});
}
constexpr auto journal_choices_of(SimplifyMethod) {
  return choices<SimplifyMethod>("simplification method", {{SimplifyMethod::Quadric, "quadric"},
                                                           {SimplifyMethod::PLaplacian, "plaplacian"}});
}
constexpr auto journal_choices_of(SubdivisionScheme) {
  return choices<SubdivisionScheme>("scheme", {{SubdivisionScheme::CatmullClark, "catmull-clark"},
                                               {SubdivisionScheme::Nuliss, "nuliss"},
                                               {SubdivisionScheme::NulissMod, "nulissmod"},
                                               {SubdivisionScheme::Linear, "linear"}});
}
constexpr auto journal_choices_of(DeformationEnergy) {
  return choices<DeformationEnergy>("energy", {{DeformationEnergy::Stretch, "stretch"},
                                               {DeformationEnergy::Bend, "bend"},
                                               {DeformationEnergy::Combined, "combined"},
                                               {DeformationEnergy::TotalCurvature, "total"}});
}
constexpr auto journal_choices_of(DetailPreservation) {
  return choices<DetailPreservation>("way to keep detail",
                                     {{DetailPreservation::None, "none"},
                                      {DetailPreservation::ShapeMatching, "shape-matching"},
                                      {DetailPreservation::GaussNewton, "gauss-newton"}});
}

}  // namespace batten
