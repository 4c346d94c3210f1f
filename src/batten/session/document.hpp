#pragma once
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/modelling/diffusion_surface.hpp"
#include "batten/sketch/polyline_mesh.hpp"
#include "batten/sketch/tools.hpp"

namespace batten {

// The edits of a document, one for each tool of sketch/tools.hpp. Lengths in the unit of the document; a snap
// of 0 takes default_snap().
struct InsertEdit {
  DrawnStroke stroke;
  InsertOptions options;
};
struct DeleteEdit {
  int curve = 0;
};
struct SharpnessEdit {
  int curve = 0;
  double value = 0;
  std::optional<std::array<int, 2>> between;  ///< two vertices of the curve: only the part between them
};
/// Of a curve of the model, or, with curve −1, of a stroke that becomes a closed curve with its image.
struct MirrorEdit {
  int curve = -1;
  DrawnStroke stroke;
  std::optional<Points> axis;  ///< 2 × 3
  InsertOptions options;
};
struct HoleEdit {
  DrawnStroke stroke;
  InsertOptions options;
};
struct GlueEdit {
  DrawnStroke first, second;
  std::optional<std::array<int, 2>> halves;
  InsertOptions options;
};
struct SkinEdit {
  std::vector<DrawnStroke> profiles;
  std::array<DrawnStroke, 2> spines;
  InsertOptions options;
};
struct AlignEdit {
  int reference = 0;
  DrawnStroke stroke;
};
struct TransformEdit {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
};
struct UndoEdit {};
struct RedoEdit {};

using Edit = std::variant<InsertEdit, DeleteEdit, SharpnessEdit, MirrorEdit, HoleEdit, GlueEdit, SkinEdit,
                          AlignEdit, TransformEdit, UndoEdit, RedoEdit>;

/// What an edit has done, with the numbers of what is new.
struct EditOutcome {
  EditReport report;
  std::vector<int> vertices;  ///< new vertices
};

/// A polyline mesh with its history. Every edit is done whole or refused and not done at all.
class Document {
 public:
  /// Called when an edit has succeeded and before it is kept; it writes the journal. What it throws undoes
  /// the edit.
  using Confirm = std::function<void(const Edit&)>;

  const PolylineMesh& mesh() const { return mesh_; }
  /// @throws RefusedEdit; the document is then as before, and so after an exception of `confirm`.
  EditOutcome apply(const Edit& edit, const Confirm& confirm = {});
  bool can_undo() const { return n_done_ > 0; }
  bool can_redo() const { return n_done_ < history_.size(); }
  /// Every edit that was done, undo and redo among them: played again, they give the same document.
  const std::vector<Edit>& log() const { return log_; }

  /// Brings the surface of the document (FIRES V2, see EditedSurface) up to date with all edits, undos and
  /// redos since it was last asked for. It is made when it is first asked for and kept; then the cost follows
  /// the edits. Other options than those of the last time begin anew, and so do copies of a document.
  /// It is that made from nothing to within five times the tolerance of the options; the same edits with the
  /// surface asked for at the same places among them give it bit for bit.
  /// @throws as EditedSurface::update() does; what was not finished is done the next time.
  SurfaceUpdate update_surface(const DiffusionOptions& options = {}, const Progress& progress = {});
  /// The same, and the whole of it. @throws as update_surface() does.
  DiffusionSurface surface(const DiffusionOptions& options = {}, const Progress& progress = {});

  /// A document without history. `log` is what led to it, for the record.
  static Document restored(PolylineMesh mesh, std::vector<Edit> log);

 private:
  PolylineMesh mesh_;
  std::vector<PolylineMesh::Change> history_;
  size_t n_done_ = 0;
  std::vector<Edit> log_;

  /// Not a part of what a document is: copies begin without one.
  struct KeptSurface {
    KeptSurface() = default;
    KeptSurface(const KeptSurface&) {}
    KeptSurface& operator=(const KeptSurface&) {
      surface.reset();
      return *this;
    }
    KeptSurface(KeptSurface&&) = default;
    KeptSurface& operator=(KeptSurface&&) = default;
    ~KeptSurface() = default;
    std::unique_ptr<EditedSurface> surface;
    DiffusionOptions options;
  };
  KeptSurface kept_;
};

/// Carries out one edit other than undo and redo within the caller's begin() and commit(), and checks what it
/// has touched. @throws RefusedEdit; std::logic_error when a tool has broken an invariant of the model.
EditReport run_tool(PolylineMesh& mesh, const Edit& edit);

}  // namespace batten
