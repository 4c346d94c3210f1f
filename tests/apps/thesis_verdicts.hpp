#pragma once

// The verdicts of `batten report thesis-s`, `thesis-h` and `thesis-h-fires` with --quick and all public data,
// as they were when they were last looked at.
namespace batten::test {

struct CommittedVerdict {
  const char* id;
  const char* verdict;  ///< of a stand-in with what it came to
};
inline constexpr CommittedVerdict kCommittedVerdicts[] = {};

}  // namespace batten::test
