#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace batten {

/// What a person says about the curve that is being drawn.
enum class MarkKind {
  Inner,     ///< a new curve inside the surface begins
  Boundary,  ///< a new curve on its boundary begins
  Node,      ///< the device is at a node
  Number,    ///< the number of the node marked last, which had none
  End,       ///< the curve is finished
  Discard,   ///< the curve is to be forgotten
  Pause,     ///< the device is lifted, or put back where it was
  Undo       ///< the node marked last was none
};

/// What a key has said, and when.
struct Mark {
  static constexpr int kUnnumbered = -1;

  std::int64_t time_us = 0;
  MarkKind kind = MarkKind::End;
  int node = kUnnumbered;  ///< of Node and Number

  bool operator==(const Mark&) const = default;
};

/// Turns keys into marks (S 5.2.1). From a keyboard: `+` new inner curve, `-` new boundary curve, digits and
/// "enter" a node, `.` finish, `/` discard, `*` pause, "backspace" the last digit or node. From a device:
/// new, node, node=N, end, undo, mode (inner or boundary), discard, pause.
///
/// Digits within two seconds make one number, which "enter", any other key or that time ends; its mark is of
/// the time of its first digit. Where fewer than ten nodes are announced each digit is a node at once. Other
/// keys are left out.
class KeyReader {
 public:
  /// @param n_nodes of the network, where that is known: below ten, each digit is a node at once.
  explicit KeyReader(std::optional<int> n_nodes = std::nullopt);

  /// @param key a character or word as above. @return marks that it completes, up to two.
  std::vector<Mark> press(std::int64_t time_us, std::string_view key);
  /// What time alone completes.
  std::vector<Mark> wait(std::int64_t time_us);
  /// Digits typed so far.
  const std::string& pending() const { return digits_; }

 private:
  void complete(std::vector<Mark>& marks);

  bool single_digits_;
  bool next_is_boundary_ = false;
  bool unnumbered_ = false;  // the node marked last
  std::string digits_;
  std::int64_t digits_since_us_ = 0, last_digit_us_ = 0;
};

/// A curve between two marks.
struct MarkedCurve {
  /// A node that was marked on the curve.
  struct Node {
    std::int64_t time_us = 0;
    int number = Mark::kUnnumbered;
  };

  bool boundary = false;
  std::int64_t begin_us = 0;
  std::optional<std::int64_t> end_us;  ///< nothing: still being drawn
  std::vector<Node> nodes;
  std::vector<std::pair<std::int64_t, std::int64_t>> pauses;  ///< from, to

  /// The last node is the first.
  bool closed() const;
};

/// The curves that marks make.
class MarkBook {
 public:
  /// @return what was odd about the mark, or nothing; such marks change nothing.
  std::optional<std::string> apply(const Mark& mark);

  const std::vector<MarkedCurve>& curves() const { return curves_; }
  /// The curve being drawn, or nothing.
  const MarkedCurve* current() const { return drawing_ ? &curves_.back() : nullptr; }
  bool paused() const { return paused_since_.has_value(); }

 private:
  void finish(std::int64_t time_us);

  std::vector<MarkedCurve> curves_;
  bool drawing_ = false;
  std::optional<std::int64_t> paused_since_;
};

}  // namespace batten
