#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "batten/core/progress.hpp"
#include "batten/session/document.hpp"
#include "batten/session/journal.hpp"

namespace batten {

/// What became of one edit of a session.
struct PlayedEdit {
  std::size_t index = 0;            ///< of the edit in the session
  std::optional<EditOutcome> done;  ///< nothing: refused
  /// The edit after which it was done, in the session; its own where it was done in its turn.
  std::size_t after = 0;
  /// Of the refusal; of edits done late, of the one in their turn. Empty where it was done in its turn.
  std::string reason, remedy;
};

/// Plays a session. A drawing edit that is refused waits, and is tried again whenever a later one of its
/// model has been done; edits that name curves wait with it where the names depend on it: curves are numbered
/// as though every edit had been done in its turn, and edits that come after a late one are translated. Where
/// the session undoes or redoes anything, nothing waits any longer. What waits at the end is refused; edits
/// that name curves are then tried with the names as they stand.
/// @return one entry per edit, in the order of the session. @throws Cancelled.
std::vector<PlayedEdit> play_session(const Session& session, Document& document,
                                     const Progress& progress = {});

}  // namespace batten
