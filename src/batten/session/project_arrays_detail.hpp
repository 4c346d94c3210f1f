#pragma once
#include <cstddef>
#include <map>
#include <string>

#include "batten/session/json_detail.hpp"

// Private to the room: long lists of numbers as entries of a project file.
namespace batten::detail {

/// Moves lists of more than 64 numbers into entries arrays/N.f64 (doubles) or arrays/N.i32 (where all are
/// whole and fit), little-endian, and leaves {"entry": name}. Equal lists share an entry.
class ArrayWriter {
 public:
  explicit ArrayWriter(std::map<std::string, std::string>& entries) : entries_(entries) {}
  void move_out(Json& json);

 private:
  std::string store(const Json::Numbers& numbers);

  std::map<std::string, std::string>& entries_;
  std::multimap<std::size_t, std::string> names_;  ///< by the hash of the bytes
  int n_ = 0;
};

/// The way back. @throws InvalidInput naming an entry that is missing or of the wrong size.
void move_in(Json& json, const std::map<std::string, std::string>& entries);

/// Doubles of format 1 and of .f64 entries.
Json::Numbers doubles_of(const std::string& bytes, const std::string& name);

}  // namespace batten::detail
