#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/session/project_arrays_detail.hpp"

namespace batten::detail {

namespace {

template <typename Bits>
void put_bits(std::string& out, Bits bits) {
  for (std::size_t i = 0; i < sizeof bits; ++i) out.push_back(static_cast<char>((bits >> (8 * i)) & 0xff));
}

template <typename Bits>
Bits bits_at(const std::string& bytes, std::size_t at) {
  Bits bits = 0;
  for (std::size_t i = 0; i < sizeof bits; ++i)
    bits |= static_cast<Bits>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
  return bits;
}

bool fits_integer(double x) {
  return x == std::floor(x) && std::abs(x) <= std::numeric_limits<std::int32_t>::max() &&
         !(x == 0 && std::signbit(x));
}

void check_size(const std::string& bytes, const std::string& name, std::size_t size) {
  if (bytes.size() % size != 0)
    throw InvalidInput(concat("the entry ", name, " has ", bytes.size(), " bytes, not a multiple of ", size));
}

Json::Numbers integers_of(const std::string& bytes, const std::string& name) {
  check_size(bytes, name, 4);
  Json::Numbers numbers(bytes.size() / 4);
  for (std::size_t i = 0; i < numbers.size(); ++i)
    numbers[i] = static_cast<std::int32_t>(bits_at<std::uint32_t>(bytes, 4 * i));
  return numbers;
}

bool ends_with(const std::string& text, std::string_view end) {
  return text.size() >= end.size() && std::string_view(text).substr(text.size() - end.size()) == end;
}

}  // namespace

void ArrayWriter::move_out(Json& json) {
  constexpr std::size_t kShort = 64;
  if (auto* numbers = json.get<Json::Numbers>()) {
    if (numbers->size() <= kShort) return;
    Json entry;
    entry.add("entry", store(*numbers));
    json = std::move(entry);
  } else if (auto* items = json.get<Json::List>()) {
    for (Json& item : *items) move_out(item);
  } else if (auto* members = json.get<Json::Object>()) {
    for (auto& [name, value] : *members) move_out(value);
  }
}

std::string ArrayWriter::store(const Json::Numbers& numbers) {
  const bool whole = std::all_of(numbers.begin(), numbers.end(), fits_integer);
  std::string bytes;
  bytes.reserve(numbers.size() * (whole ? 4 : 8));
  for (const double number : numbers) {
    if (whole) {
      put_bits(bytes, static_cast<std::uint32_t>(static_cast<std::int32_t>(number)));
      continue;
    }
    std::uint64_t bits = 0;
    std::memcpy(&bits, &number, sizeof bits);
    put_bits(bytes, bits);
  }
  const std::string_view suffix = whole ? ".i32" : ".f64";
  const std::size_t hash = std::hash<std::string>()(bytes);
  const auto [first, last] = names_.equal_range(hash);
  for (auto same = first; same != last; ++same)
    if (ends_with(same->second, suffix) && entries_.at(same->second) == bytes) return same->second;
  const std::string name = concat("arrays/", n_++, suffix);
  names_.emplace(hash, name);
  entries_[name] = std::move(bytes);
  return name;
}

void move_in(Json& json, const std::map<std::string, std::string>& entries) {
  if (auto* items = json.get<Json::List>()) {
    for (Json& item : *items) move_in(item, entries);
    return;
  }
  auto* members = json.get<Json::Object>();
  if (!members) return;
  const auto* name = members->size() == 1 && members->front().first == "entry"
                         ? members->front().second.get<std::string>()
                         : nullptr;
  if (!name) {
    for (auto& [key, value] : *members) move_in(value, entries);
    return;
  }
  const auto entry = entries.find(*name);
  if (entry == entries.end()) throw InvalidInput(concat("the entry ", *name, " is missing"));
  if (!ends_with(*name, ".i32") && !ends_with(*name, ".f64"))
    throw InvalidInput(concat("the entry ", *name, " is no array; it must end in .f64 or .i32"));
  json =
      Json(ends_with(*name, ".i32") ? integers_of(entry->second, *name) : doubles_of(entry->second, *name));
}

Json::Numbers doubles_of(const std::string& bytes, const std::string& name) {
  check_size(bytes, name, 8);
  Json::Numbers numbers(bytes.size() / 8);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto bits = bits_at<std::uint64_t>(bytes, 8 * i);
    std::memcpy(&numbers[i], &bits, sizeof bits);
  }
  return numbers;
}

}  // namespace batten::detail
