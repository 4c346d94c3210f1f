#include "studio/engine_thread.hpp"
#include "studio/step_file.hpp"

#include <memory>

#include "batten/engine/engine.hpp"

namespace batten::studio {

Handle make_engine() {
  return [engine = std::make_shared<Engine>(step_file)](std::string_view text, std::string_view bytes,
                                                        const Progress& progress) {
    return engine->handle(text, bytes, progress);
  };
}

}  // namespace batten::studio
