#pragma once
#include <memory>
#include <string>
#include <variant>

#include "batten/session/object.hpp"
#include "batten/session/request.hpp"
#include "batten/session/sketch_edit.hpp"

namespace batten {

// The edits of a project. Edits with a field `drag` may be one of many that a slider or a handle sends while
// it is dragged: those that follow each other with one drag number other than 0, of the same option of the
// same object, are one edit, the last of them. The number of a drag is not written to journals.

/// A new object with given content.
struct AddEdit {
  ObjectId object;  ///< its number, higher than any so far; 0 takes the next
  std::string name;
  std::string unit;
  Content content;  ///< a null model is an empty one
};
/// A new object that is made of another one.
struct DeriveEdit {
  ObjectId object;  ///< as in AddEdit
  std::string name;
  ObjectId source;
  Request request;
};
/// Takes an object away.
struct RemoveEdit {
  ObjectId object;
  bool with_derived = false;  ///< and all that is made of it; off: refused where there is such an object
};
/// Another name for an object.
struct RenameEdit {
  ObjectId object;
  std::string name;
};
/// Says in which unit the numbers are; they stay as they are.
struct UnitEdit {
  ObjectId object;
  std::string unit;
};
/// Other content of the same kind, for given objects but models; a derived object becomes a given one.
struct ReplaceEdit {
  ObjectId object;
  Content content;
};
/// Another curve in the place of one of a scan; the others are neither copied nor kept twice.
struct ScanCurveEdit {
  ObjectId object;
  int curve = 0;  ///< its index
  std::shared_ptr<const ScanCurve> content;
  int drag = 0;
};
/// Other options of a derived object. Another request of the same kinds of source and result is allowed.
struct RequestEdit {
  ObjectId object;
  Request request;
  int drag = 0;
};
/// Another state of a view.
struct ViewEdit {
  ObjectId object;
  ViewState view;
  int drag = 0;
};
/// A tool of a model. Within a drag, what counts is the model before the drag.
struct ModelEdit {
  ObjectId object;
  SketchEdit edit;
  int drag = 0;
};
struct UndoEdit {};
struct RedoEdit {};
/// What was done before cannot be undone any more. Frees its memory.
struct CheckpointEdit {};

using Edit = std::variant<AddEdit, DeriveEdit, RemoveEdit, RenameEdit, UnitEdit, ReplaceEdit, ScanCurveEdit,
                          RequestEdit, ViewEdit, ModelEdit, UndoEdit, RedoEdit, CheckpointEdit>;

/// The name of an edit in journals: "add", "rename", and "insert", "delete", … for tools of models.
std::string name_of_op(const Edit& edit);

/// Whether two edits that follow each other are of one drag of one option, as far as the edits alone tell.
bool within_one_drag(const Edit& first, const Edit& second);

}  // namespace batten
