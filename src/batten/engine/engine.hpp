#pragma once
#include <memory>
#include <string>
#include <string_view>

#include "batten/core/progress.hpp"
#include "batten/engine/reply.hpp"

namespace batten {

/// The engine behind the studio: one project, requests as JSON messages, replies as JSON and arrays
/// (docs/engine.md lists the messages). The page holds one in a worker, the server one per window; both are
/// asked the same.
///
/// Not for several threads at once.
class Engine {
 public:
  Engine();
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
