#pragma once

namespace batten::test {

/// Whether the tests run under sanitizers, where all takes ten times as long. They look at the code, and the
/// code is the same for the second seed and the ninth shape: figures over many of them are taken without.
#ifdef BATTEN_SANITIZED
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// A number of repetitions or a size: `all`, under sanitizers `few`.
template <typename Number>
constexpr Number repeated(Number all, Number few) {
  return kSanitized ? few : all;
}

}  // namespace batten::test
