#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/modelling/model_surface.hpp"
#include "batten/pipeline/deformed_mesh.hpp"
#include "batten/pipeline/faired_mesh.hpp"
#include "batten/pipeline/network_surface.hpp"
#include "batten/pipeline/remeshed_mesh.hpp"
#include "batten/pipeline/repaired_mesh.hpp"
#include "batten/pipeline/simplified_mesh.hpp"
#include "batten/pipeline/subdivided_cage.hpp"
#include "batten/scan/reconstruct.hpp"
#include "batten/session/document.hpp"
#include "batten/session/object.hpp"
#include "batten/session/request.hpp"

namespace batten {

/// What a request gives, in the order of Request and RequestKind.
using RequestResult = std::variant<ScanNetwork, CurvesSurface, ModelSurface, FairedMesh, RemeshedMesh,
                                   SimplifiedMesh, SubdividedCage, DeformedMesh, RepairedMesh>;

/// Does what a request asks: one call for every kind. A mesh that is a cage is refined as it is, all its
/// edges smooth.
/// @param source of the kind source_kind(); not null.
/// @throws InvalidInput where the source is of another kind or the options name what it has not, and as the
/// function that the request names; SolverFailure; Cancelled.
RequestResult run(const Request& request, const Content& source, const Progress& progress = {});

/// The network or mesh of a result, which shares the result's memory. @pre not null.
Content content_of(const std::shared_ptr<const RequestResult>& result);
/// All warnings of a result, those of its first step first.
std::vector<std::string> warnings_of(const RequestResult& result);
/// The times of all steps of a result.
StageTimes times_of(const RequestResult& result);

/// The results of the derived objects of one document, each made when it is asked for and kept until it is
/// out of date. Holds the newest result of every object alone: what undo brings back is made again.
class Results {
 public:
  /// The result of a derived object, with what it is made of brought up to date first, sources first. A
  /// failure, or a stop, keeps the results that were finished.
  /// @throws InvalidInput where there is no such object or it is not derived; as run(), with the name of the
  /// object that could not be made in front.
  std::shared_ptr<const RequestResult> get(const Document& document, ObjectId id,
                                           const Progress& progress = {});
  /// The content of any object but a model: as given, or as get().
  Content content(const Document& document, ObjectId id, const Progress& progress = {});

  /// The version that each kept result was made with, for Document::out_of_date().
  std::map<ObjectId, std::uint64_t> versions() const;

 private:
  struct Kept {
    std::uint64_t version;
    std::shared_ptr<const RequestResult> result;
  };
  std::map<ObjectId, Kept> kept_;
};

}  // namespace batten
