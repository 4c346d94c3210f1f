#pragma once
#include "batten/session/json_detail.hpp"
#include "batten/session/object.hpp"

// Private to the room: what objects hold, in journals and project files.
namespace batten::detail {

/// The fields of a content; for a null model none.
Json json_of(const Content& content);
/// @throws InvalidInput naming the field.
Content content_of(ObjectKind kind, const Json& json);

Json json_of(const ScanCurve& curve);
/// @param what names the curve in errors. @throws InvalidInput naming the field.
ScanCurve scan_curve_of(const Json& json, const std::string& what);

Json json_of_model(const PolylineMesh& model);
/// @throws InvalidInput naming the field or the invariant of the model that is broken.
PolylineMesh model_of(const Json& json);

}  // namespace batten::detail
