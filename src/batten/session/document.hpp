#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "batten/session/edit.hpp"
#include "batten/session/object.hpp"

namespace batten {

/// Where a journal puts an edit.
enum class LogPlace {
  Append,
  ReplaceLast,  ///< in place of the last one: a drag goes on
};

/// What an edit has done, with the numbers of what is new.
struct EditOutcome {
  EditReport report;               ///< of the tool of a model
  std::vector<int> vertices;       ///< new vertices of the model
  ObjectId object;                 ///< that was added, or the one edited; 0 for undo, redo and checkpoints
  std::vector<ObjectId> changed;   ///< added, removed, or changed in any way, ascending
  std::vector<ObjectId> outdated;  ///< derived objects whose results are out of date, sources first
  bool merged = false;             ///< into the edit before: a drag goes on
};

/// A project that is being edited: named objects and one history of edits over all of them. Every edit is
/// done whole or refused and not done at all.
///
/// A document knows what is asked of its objects, not how it is made: results of derived objects are made and
/// kept by the caller, who is told which are out of date.
///
/// Undo costs what the edit has changed. Contents are shared, models remember what an edit has touched and
/// scans which curve, so that an edit that brings no data keeps none.
class Document {
 public:
  /// Called when an edit has succeeded and before it is kept; it writes the journal. What it throws undoes
  /// the edit. The edit is given with the number of its object.
  using Confirm = std::function<void(const Edit&, LogPlace)>;

  /// @throws RefusedEdit with reason and remedy; the document is then as before, and so after an exception of
  /// `confirm`.
  EditOutcome apply(const Edit& edit, const Confirm& confirm = {});
  bool can_undo() const { return n_done_ > 0; }
  bool can_redo() const { return n_done_ < history_.size(); }
  /// Every edit that was done, undo and redo among them: played again, they give the same document.
  const std::vector<Edit>& log() const { return log_; }

  /// Ascending: in the order in which they were added, sources before what is made of them.
  std::vector<ObjectId> objects() const;
  /// Nothing where there is no such object.
  const Object* find(ObjectId id) const;
  ObjectId find(std::string_view name) const;  ///< 0 where there is none
  /// @throws InvalidInput where there is no such object.
  const Object& object(ObjectId id) const;
  /// The same, to be kept beyond the next edit. Null where there is no such object.
  std::shared_ptr<const Object> shared(ObjectId id) const;
  /// The number that the next object gets.
  int next_number() const { return next_; }
  /// The curves and faces of a model; the reference holds as long as the document.
  /// @throws InvalidInput where there is no such model.
  const PolylineMesh& model(ObjectId id) const;
  /// The unit of the lengths of an object; that of the source where it is derived.
  const std::string& unit(ObjectId id) const;

  /// A number that changes with everything that the result of an object depends on: its content or request,
  /// its unit, and the same of all that it is made of; not its name. Undo brings back the number of before,
  /// and no number comes twice otherwise: a result that was kept with its number is as good as made anew
  /// where the number is the same. Copies of a document number on their own.
  std::uint64_t version(ObjectId id) const;
  /// The derived objects whose results are not those of `made` (the version with which each was made last),
  /// sources first.
  std::vector<ObjectId> out_of_date(const std::map<ObjectId, std::uint64_t>& made) const;
  /// What is made of an object, directly or by way of others, ascending.
  std::vector<ObjectId> derived_from(ObjectId id) const;

  /// A document of these objects whose log is nothing but them and a checkpoint. Models are those of
  /// `models`. @throws RefusedEdit as the edits that add them.
  static Document restored(const std::map<ObjectId, Object>& objects,
                           const std::map<ObjectId, SharedModel>& models);

  /// Equal objects with equal numbers, whatever led to them; numbers bit for bit.
  bool operator==(const Document& other) const;

 private:
  struct Slot {
    std::shared_ptr<const Object> object;  ///< null: no such object
    std::uint64_t version = 0;
  };
  struct SlotChange {
    ObjectId id;
    Slot before, after;
  };
  /// A curve of a scan, forth and back.
  struct CurveChange {
    std::size_t index = 0;
    std::shared_ptr<const ScanCurve> before, after;
  };
  /// One edit, forth and back.
  struct Step {
    ObjectId object;
    /// Of a step with a `curve`, the slot of `object` holds versions only: its object would be the whole
    /// scan.
    std::vector<SlotChange> slots;
    int next_before = 0, next_after = 0;
    std::optional<PolylineMesh::Change> model;  ///< of `object`
    std::optional<CurveChange> curve;           ///< of `object`
    /// For drags: the options of a request that the edits of the drag have changed.
    std::vector<std::string> options;
  };

  EditOutcome go_back(const Edit& edit, const Confirm& confirm);
  EditOutcome go_on(const Edit& edit, const Confirm& confirm);
  EditOutcome carry_out(Edit edit, const Confirm& confirm);
  std::optional<std::vector<std::string>> options_of_drag(const Edit& edit) const;
  EditOutcome do_edit(Edit edit, const Confirm& confirm, LogPlace place, std::vector<std::string> options);
  void set_slots(const Step& step, bool forwards);
  void put(const Step& step, bool forwards);  ///< the same, and the model
  EditOutcome outcome_of(const Step& step) const;
  void put_curve(ObjectId id, std::size_t index, const ScanCurve& curve);

  std::map<ObjectId, Slot> slots_;
  std::map<ObjectId, PolylineMesh> models_;  ///< also of models that undo has taken away
  /// Scans that were copied for an edit of a curve: while nobody else holds one, further edits change it.
  std::map<ObjectId, std::shared_ptr<Scan>> edited_scans_;
  int next_ = 1;
  std::uint64_t last_version_ = 0;
  std::vector<Step> history_;
  std::size_t n_done_ = 0;
  std::vector<Edit> log_;
};

}  // namespace batten
