#include "batten/capture/keys.hpp"

#include "batten/core/text.hpp"

namespace batten {

namespace {

constexpr std::int64_t kDigitsTogether = 2000000;  // microseconds
constexpr std::size_t kMostDigits = 6;

std::optional<MarkKind> simple_mark(std::string_view key) {
  if (key == ".") return MarkKind::End;
  if (key == "/") return MarkKind::Discard;
  if (key == "*") return MarkKind::Pause;
  if (key == "end") return MarkKind::End;
  if (key == "discard") return MarkKind::Discard;
  if (key == "pause") return MarkKind::Pause;
  if (key == "undo") return MarkKind::Undo;
  return std::nullopt;
}

}  // namespace

KeyReader::KeyReader(std::optional<int> n_nodes) : single_digits_(n_nodes && *n_nodes < 10) {}

void KeyReader::complete(std::vector<Mark>& marks) {
  if (digits_.empty()) return;
  Mark mark;
  mark.time_us = digits_since_us_;
  mark.kind = unnumbered_ ? MarkKind::Number : MarkKind::Node;
  mark.node = std::stoi(digits_);
  marks.push_back(mark);
  unnumbered_ = false;
  digits_.clear();
}

std::vector<Mark> KeyReader::wait(std::int64_t time_us) {
  std::vector<Mark> marks;
  if (time_us - last_digit_us_ > kDigitsTogether) complete(marks);
  return marks;
}

std::vector<Mark> KeyReader::press(std::int64_t time_us, std::string_view key) {
  std::vector<Mark> marks = wait(time_us);
  if (key.size() == 1 && key[0] >= '0' && key[0] <= '9') {
    if (digits_.empty()) digits_since_us_ = time_us;
    digits_ += key[0];
    last_digit_us_ = time_us;
    if (single_digits_ || digits_.size() == kMostDigits) complete(marks);
    return marks;
  }
  if (key == "backspace" && !digits_.empty()) {
    digits_.pop_back();
    return marks;
  }
  complete(marks);
  if (key == "+" || key == "-" || key == "new") {
    const bool boundary = key == "-" || (key == "new" && next_is_boundary_);
    marks.push_back({time_us, boundary ? MarkKind::Boundary : MarkKind::Inner, Mark::kUnnumbered});
    unnumbered_ = false;
  } else if (key == "mode") {
    next_is_boundary_ = !next_is_boundary_;
  } else if (key == "node") {
    marks.push_back({time_us, MarkKind::Node, Mark::kUnnumbered});
    unnumbered_ = true;
  } else if (key.substr(0, 5) == "node=") {
    long number = 0;
    if (key.size() <= 5 + kMostDigits && parse_integer(key.substr(5), number) && number >= 0) {
      marks.push_back({time_us, MarkKind::Node, static_cast<int>(number)});
      unnumbered_ = false;
    }
  } else if (key == "backspace") {
    marks.push_back({time_us, MarkKind::Undo, Mark::kUnnumbered});
    unnumbered_ = false;
  } else if (const std::optional<MarkKind> kind = simple_mark(key)) {
    marks.push_back({time_us, *kind, Mark::kUnnumbered});
    if (*kind != MarkKind::Pause) unnumbered_ = false;
  }
  return marks;
}

bool MarkedCurve::closed() const {
  return nodes.size() > 1 && nodes.front().number == nodes.back().number &&
         nodes.front().number != Mark::kUnnumbered;
}

void MarkBook::finish(std::int64_t time_us) {
  if (paused_since_) curves_.back().pauses.emplace_back(*paused_since_, time_us);
  paused_since_.reset();
  curves_.back().end_us = time_us;
  drawing_ = false;
}

std::optional<std::string> MarkBook::apply(const Mark& mark) {
  if (mark.kind == MarkKind::Inner || mark.kind == MarkKind::Boundary) {
    std::optional<std::string> odd;
    if (drawing_) {
      odd = concat("curve ", curves_.size(), " was not finished when the next began");
      finish(mark.time_us);
    }
    curves_.emplace_back();
    curves_.back().boundary = mark.kind == MarkKind::Boundary;
    curves_.back().begin_us = mark.time_us;
    drawing_ = true;
    return odd;
  }
  if (!drawing_) return "a key was pressed while no curve was drawn; begin one with + or -";
  MarkedCurve& curve = curves_.back();
  switch (mark.kind) {
    case MarkKind::Node:
      curve.nodes.push_back({mark.time_us, mark.node});
      break;
    case MarkKind::Number:
      if (curve.nodes.empty()) return "a number was given where no node was marked";
      curve.nodes.back().number = mark.node;
      break;
    case MarkKind::Undo:
      if (curve.nodes.empty()) return "there was no node to take back";
      curve.nodes.pop_back();
      break;
    case MarkKind::Pause:
      if (paused_since_) {
        curve.pauses.emplace_back(*paused_since_, mark.time_us);
        paused_since_.reset();
      } else {
        paused_since_ = mark.time_us;
      }
      break;
    case MarkKind::Discard:
      curves_.pop_back();
      drawing_ = false;
      paused_since_.reset();
      break;
    default:
      finish(mark.time_us);
  }
  return std::nullopt;
}

}  // namespace batten
