#pragma once
#include <utility>

#include "batten/session/document.hpp"

// A document with one model, as sketching programs hold it.
namespace batten::test {

constexpr ObjectId kModel{1};

/// An empty model that undo does not take away.
inline Document one_model() {
  Document document;
  document.apply(AddEdit{kModel, "model", "m", SharedModel()});
  document.apply(CheckpointEdit{});
  return document;
}

inline Edit on_model(SketchEdit edit) {
  return ModelEdit{kModel, std::move(edit), 0};
}

inline const PolylineMesh& model_of(const Document& document) {
  return document.model(kModel);
}

}  // namespace batten::test
