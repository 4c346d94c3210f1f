#include "batten/session/playing.hpp"

#include <map>
#include <utility>
#include <variant>

namespace batten {

namespace {

/// How many curves an edit of a model makes when it is done; nothing where that depends on the model.
std::optional<int> curves_made_by(const SketchEdit& edit) {
  if (std::holds_alternative<InsertEdit>(edit) || std::holds_alternative<MirrorEdit>(edit)) return 1;
  if (std::holds_alternative<GlueEdit>(edit)) return 2;
  if (const auto* skin = std::get_if<SkinEdit>(&edit)) return static_cast<int>(skin->profiles.size()) + 2;
  if (std::holds_alternative<HoleEdit>(edit)) return std::nullopt;
  return 0;
}

bool draws(const SketchEdit& edit) {
  return curves_made_by(edit) != 0;
}

/// The names of curves in an edit.
std::vector<int*> curves_named_by(SketchEdit& edit) {
  if (auto* e = std::get_if<DeleteEdit>(&edit)) return {&e->curve};
  if (auto* e = std::get_if<SharpnessEdit>(&edit)) return {&e->curve};
  if (auto* e = std::get_if<AlignEdit>(&edit)) return {&e->reference};
  if (auto* e = std::get_if<MirrorEdit>(&edit); e && e->curve >= 0) return {&e->curve};
  if (auto* e = std::get_if<GlueEdit>(&edit); e && e->halves) return {&(*e->halves)[0], &(*e->halves)[1]};
  return {};
}

/// The curves of a model as the session numbers them, and as they are.
class CurveNumbers {
 public:
  /// The curves of one drawing edit: the first of them, or −1 while it waits, and how many; nothing: not
  /// known.
  struct Run {
    std::size_t edit = 0;
    int first = -1;
    std::optional<int> count;
  };
  void add(const Run& run) { runs_.push_back(run); }
  void set(const Run& done) {
    for (Run& run : runs_)
      if (run.edit == done.edit) run = done;
  }
  /// What the session calls `curve`; nothing while that depends on an edit that waits.
  std::optional<int> actual(int curve) const {
    int next = 0;
    for (const Run& run : runs_) {
      if (run.count && curve < next + *run.count) {
        if (run.first < 0) return std::nullopt;
        return run.first + curve - next;
      }
      if (!run.count) return std::nullopt;
      next += *run.count;
    }
    return curve;  // there is none, and the tool says so
  }

 private:
  std::vector<Run> runs_;
};

/// The state of play_session().
class Player {
 public:
  Player(const Session& session, Document& document) : session_(session), document_(document) {
    played_.resize(session.edits.size());
    for (std::size_t k = 0; k < played_.size(); ++k) played_[k].index = played_[k].after = k;
  }

  void play(std::size_t k) {
    const Edit& edit = session_.edits[k].edit;
    if (std::holds_alternative<UndoEdit>(edit) || std::holds_alternative<RedoEdit>(edit)) {
      end_of_waiting(k);
      may_wait_ = false;
    }
    const auto* on_model = std::get_if<ModelEdit>(&edit);
    if (on_model && may_wait_ && !translated(*on_model)) {
      waiting_.push_back(k);  // for its names
      return;
    }
    if (!attempt(k, k)) {
      if (!on_model || !may_wait_ || !draws(on_model->edit)) return;
      waiting_.push_back(k);
      numbers_[on_model->object].add({k, -1, curves_made_by(on_model->edit)});
      return;
    }
    if (on_model && draws(on_model->edit)) retry(k);
  }

  std::vector<PlayedEdit> finish() {
    end_of_waiting(session_.edits.empty() ? 0 : session_.edits.size() - 1);
    return std::move(played_);
  }

 private:
  /// The edit with the names that its curves have now; nothing while one of them is not known.
  std::optional<ModelEdit> translated(const ModelEdit& edit) const {
    ModelEdit result = edit;
    const auto numbers = numbers_.find(edit.object);
    if (numbers == numbers_.end()) return result;
    for (int* curve : curves_named_by(result.edit)) {
      const auto actual = numbers->second.actual(*curve);
      if (!actual) return std::nullopt;
      *curve = *actual;
    }
    return result;
  }

  int n_curves(ObjectId object) const {
    const Object* found = document_.find(object);
    return found && found->kind() == ObjectKind::Model ? document_.model(object).n_curves() : 0;
  }

  /// Tries an edit after another one of the session. @return whether it was done.
  bool attempt(std::size_t k, std::size_t after) {
    PlayedEdit& entry = played_[k];
    Edit edit = session_.edits[k].edit;
    const auto* on_model = std::get_if<ModelEdit>(&edit);
    if (on_model && may_wait_)
      if (auto named = translated(*on_model)) edit = std::move(*named);
    on_model = std::get_if<ModelEdit>(&edit);
    const int before = on_model ? n_curves(on_model->object) : 0;
    try {
      entry.done = document_.apply(edit);
    } catch (const RefusedEdit& refusal) {
      entry.reason = entry.reason.empty() ? refusal.reason() : entry.reason;
      entry.remedy = entry.remedy.empty() ? refusal.remedy() : entry.remedy;
      return false;
    }
    entry.after = after;
    if (on_model && draws(on_model->edit)) {
      const CurveNumbers::Run run{k, before, n_curves(on_model->object) - before};
      if (after == k)
        numbers_[on_model->object].add(run);
      else
        numbers_[on_model->object].set(run);
    }
    return true;
  }

  /// Tries again what waits, as long as anything comes of it.
  void retry(std::size_t after) {
    for (bool any = true; any;) {
      any = false;
      for (auto k = waiting_.begin(); k != waiting_.end();) {
        const auto* on_model = std::get_if<ModelEdit>(&session_.edits[*k].edit);
        if (translated(*on_model) && attempt(*k, after)) {
          any = true;
          k = waiting_.erase(k);
        } else {
          ++k;
        }
      }
    }
  }

  void end_of_waiting(std::size_t after) {
    may_wait_ = false;  // names are taken as they stand
    for (const std::size_t k : waiting_)
      if (played_[k].reason.empty()) attempt(k, after);
    waiting_.clear();
    numbers_.clear();
  }

  const Session& session_;
  Document& document_;
  std::vector<PlayedEdit> played_;
  std::vector<std::size_t> waiting_;  // in the order of the session
  std::map<ObjectId, CurveNumbers> numbers_;
  bool may_wait_ = true;
};

}  // namespace

std::vector<PlayedEdit> play_session(const Session& session, Document& document, const Progress& progress) {
  Player player(session, document);
  for (std::size_t k = 0; k < session.edits.size(); ++k) {
    progress.report("edits", static_cast<double>(k) / static_cast<double>(session.edits.size()));
    player.play(k);
  }
  return player.finish();
}

}  // namespace batten
