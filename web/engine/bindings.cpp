// The engine as a JavaScript class. What crosses the border: text, bytes, plain arrays; nothing throws.
#include <cstddef>
#include <string>
#include <utility>

#include <emscripten/bind.h>
#include <emscripten/val.h>

#include "batten/engine/engine.hpp"

namespace {

using emscripten::val;

/// A copy of the bytes as an array of the page: a view of the memory would end when the memory grows.
val array_of(const batten::ReplyArray& array) {
  const auto* bytes = reinterpret_cast<const unsigned char*>(array.bytes.data());
  const val copy = val(emscripten::typed_memory_view(array.bytes.size(), bytes)).call<val>("slice");
  const char* type = array.type == batten::ElementType::Float32  ? "Float32Array"
                     : array.type == batten::ElementType::Uint32 ? "Uint32Array"
                                                                 : "Uint8Array";
  return val::global(type).new_(copy["buffer"]);
}

class PageEngine {
 public:
  /// @param bytes a string of bytes or a Uint8Array. @param progress null, or a function of stage and
  /// fraction that answers false to stop.
  val handle(const std::string& message, const std::string& bytes, const val& progress) {
    batten::Progress told;
    if (!progress.isNull() && !progress.isUndefined())
      told = batten::Progress([&progress](std::string_view stage, double fraction) {
        return progress(std::string(stage), fraction).as<bool>();
      });
    const batten::Reply reply = engine_.handle(message, bytes, told);
    val result = val::object();
    result.set("text", reply.text);
    val arrays = val::object();
    for (const batten::ReplyArray& array : reply.arrays) arrays.set(array.name, array_of(array));
    result.set("arrays", arrays);
    return result;
  }

 private:
  batten::Engine engine_;
};

}  // namespace

EMSCRIPTEN_BINDINGS(batten_engine) {
  emscripten::class_<PageEngine>("Engine").constructor<>().function("handle", &PageEngine::handle);
}
