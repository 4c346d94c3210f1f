#pragma once
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "batten/core/progress.hpp"
#include "batten/engine/reply.hpp"
#include "batten/session/results.hpp"

namespace batten {

/// The text of a STEP file of a surface, for programs that link Open Cascade. @param unit of its lengths.
using FormatStep =
    std::function<std::string(const RequestResult& made, const std::string& unit, const Progress&)>;

/// The engine behind the studio: one project, requests as JSON messages, replies as JSON and arrays
/// (docs/engine.md lists the messages). The page holds one in a worker, the server one per window; both are
/// asked the same.
///
/// Not for several threads at once.
class Engine {
 public:
  /// @param format_step surfaces can be saved as `step` where there is one.
  explicit Engine(FormatStep format_step = {});
  ~Engine();
  Engine(Engine&&) noexcept;
  Engine& operator=(Engine&&) noexcept;

  /// Carries out one message. Everything that goes wrong is a reply with "ok": false and the sentence that
  /// the command line would print, with the remedy where there is one; the project is then as before.
  /// @param message a JSON object with "op" and what belongs to it. @param bytes of a file, where it brings
  /// one.
  Reply handle(std::string_view message, std::string_view bytes = {}, const Progress& progress = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace batten
