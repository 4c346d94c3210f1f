// Runs a fuzz target on a corpus and on seeded mutations of it: the same inputs on every machine.
//
//   fuzz_<name> <folder or file>... [--mutations N] [--seed S] [--only K] [--save FILE]
//
// Input 0 … n − 1 are the files in the order of their names, the next N are mutations. Where an input fails,
// its number is printed; `--only K --save FILE` runs it alone and writes it to a file.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <unistd.h>

#include "batten/core/random.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
// Of the address sanitizer, where it is linked in.
extern "C" void __sanitizer_set_death_callback(void (*callback)()) __attribute__((weak));

namespace {

using batten::Random;

// An input that takes longer than this hangs (seconds; sanitizers and busy machines included).
constexpr unsigned kLongestRun = 60;
// Mutated inputs stay below this size, so that a fixed number of them takes a bounded time.
constexpr size_t kLargestInput = size_t{1} << 16;

long current_input = -1;

void tell_input() {
  std::fprintf(stderr, "fuzz: input %ld failed; run with --only %ld --save FILE to look at it\n",
               current_input, current_input);
}

struct Arguments {
  std::vector<std::string> places;
  long mutations = 1000;
  long only = -1;
  std::uint64_t seed = 1;
  std::string save;
};

Arguments parse_arguments(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const char* value = i + 1 < argc ? argv[i + 1] : "";
    if (word == "--mutations") {
      arguments.mutations = std::atol(value), ++i;
    } else if (word == "--seed") {
      arguments.seed = static_cast<std::uint64_t>(std::atoll(value)), ++i;
    } else if (word == "--only") {
      arguments.only = std::atol(value), ++i;
    } else if (word == "--save") {
      arguments.save = value, ++i;
    } else {
      arguments.places.push_back(word);
    }
  }
  return arguments;
}

std::vector<std::string> read_corpus(const std::vector<std::string>& places) {
  std::vector<std::filesystem::path> files;
  for (const std::string& place : places) {
    if (std::filesystem::is_directory(place)) {
      for (const auto& entry : std::filesystem::directory_iterator(place)) files.push_back(entry.path());
    } else {
      files.emplace_back(place);
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<std::string> corpus;
  for (const auto& file : files) {
    std::ifstream in(file, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  return corpus;
}

size_t position_in(const std::string& text, Random& random) {
  return text.empty() ? 0 : random.below(text.size() + 1);
}

/// Numbers that break arithmetic or counts, and text that breaks syntax.
std::string awkward_token(Random& random) {
  static const std::array<const char*, 22> kTokens = {
      "0",          "-1",          "1",           "2",          "nan",
      "-inf",       "1e308",       "1e-320",      "255",        "65536",
      "2147483647", "2147483648",  "-2147483649", "4294967296", "99999999999999999999",
      "#",          "\"",          ",",           "{",          "]",
      "\r\n",       "\xEF\xBB\xBF"};
  return kTokens[random.below(kTokens.size())];
}

/// A stretch of the text: short ones are more likely.
std::pair<size_t, size_t> stretch(const std::string& text, Random& random) {
  const size_t begin = position_in(text, random);
  const size_t longest = text.size() - begin;
  const size_t length = longest == 0 ? 0 : random.below(std::min(longest, size_t{1} << random.below(12)) + 1);
  return {begin, length};
}

/// The token (no blanks, commas or line ends) around a random place.
std::pair<size_t, size_t> token_at(const std::string& text, Random& random) {
  const char* const kSeparators = " \t\r\n,";
  size_t begin = text.find_first_not_of(kSeparators, position_in(text, random));
  if (begin == std::string::npos) return {text.size(), 0};
  while (begin > 0 && std::strchr(kSeparators, text[begin - 1]) == nullptr) --begin;
  size_t end = text.find_first_of(kSeparators, begin);
  if (end == std::string::npos) end = text.size();
  return {begin, end - begin};
}

/// The line around a random place, with its end.
std::pair<size_t, size_t> line_at(const std::string& text, Random& random) {
  const size_t place = position_in(text, random);
  size_t begin = place == 0 ? std::string::npos : text.rfind('\n', place - 1);
  begin = begin == std::string::npos ? 0 : begin + 1;
  const size_t end = text.find('\n', begin);
  return {begin, end == std::string::npos ? text.size() - begin : end + 1 - begin};
}

void mutate_once(std::string& text, const std::vector<std::string>& corpus, Random& random) {
  switch (random.below(11)) {
    case 0:
      if (!text.empty()) text[random.below(text.size())] ^= static_cast<char>(1U << random.below(8));
      break;
    case 1:
      if (!text.empty()) text[random.below(text.size())] = static_cast<char>(random.below(256));
      break;
    case 2: {
      const auto [begin, length] = stretch(text, random);
      text.erase(begin, length);
      break;
    }
    case 3: {
      const auto [begin, length] = stretch(text, random);
      text.insert(position_in(text, random), text.substr(begin, length));
      break;
    }
    case 4:
      text.resize(position_in(text, random));
      break;
    case 5:
      text.insert(position_in(text, random), awkward_token(random));
      break;
    case 6:
    case 7: {
      const auto [begin, length] = token_at(text, random);
      text.replace(begin, length, awkward_token(random));
      break;
    }
    case 8: {
      const auto [begin, length] = line_at(text, random);
      text.erase(begin, length);
      break;
    }
    case 9: {
      const auto [begin, length] = line_at(text, random);
      text.insert(line_at(text, random).first, text.substr(begin, length));
      break;
    }
    default: {
      const std::string& other = corpus[random.below(corpus.size())];
      text = text.substr(0, position_in(text, random)) + other.substr(position_in(other, random));
    }
  }
  if (text.size() > kLargestInput) text.resize(kLargestInput);
}

std::string make_input(long number, const std::vector<std::string>& corpus, std::uint64_t seed) {
  const auto n_files = static_cast<long>(corpus.size());
  if (number < n_files) return corpus[static_cast<size_t>(number)];
  Random random(seed, static_cast<std::uint64_t>(number));
  std::string text = corpus[random.below(corpus.size())];
  const std::uint64_t rounds = 1 + random.below(6);
  for (std::uint64_t i = 0; i < rounds; ++i) mutate_once(text, corpus, random);
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  const Arguments arguments = parse_arguments(argc, argv);
  const std::vector<std::string> corpus = read_corpus(arguments.places);
  if (corpus.empty()) {
    std::fprintf(stderr, "fuzz: the corpus is empty\n");
    return 1;
  }
  if (__sanitizer_set_death_callback != nullptr) __sanitizer_set_death_callback(tell_input);
  std::set_terminate([] {
    tell_input();
    std::abort();
  });
  const long end = static_cast<long>(corpus.size()) + arguments.mutations;
  for (long number = 0; number < end; ++number) {
    if (arguments.only >= 0 && number != arguments.only) continue;
    current_input = number;
    const std::string input = make_input(number, corpus, arguments.seed);
    if (!arguments.save.empty()) std::ofstream(arguments.save, std::ios::binary) << input;
    // An exact copy on the heap, so that the sanitizer sees a read past its end.
    const std::vector<std::uint8_t> bytes(input.begin(), input.end());
    alarm(kLongestRun);
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
    alarm(0);
  }
  std::printf("%ld inputs, %zu of them from the corpus\n", end, corpus.size());
  return 0;
}
