#include "batten/core/choices.hpp"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace batten {

// Not in the unnamed namespace: an enumeration's words are found in the namespace of the enumeration.
namespace choices_test {

enum class Metal { Iron, Copper, Tin };
constexpr auto choices_of(Metal) {
  return choices<Metal>(
      "metal",
      {{Metal::Copper, "copper"}, {Metal::Iron, "iron"}, {Metal::Iron, "fe"}, {Metal::Tin, "white-tin"}});
}

}  // namespace choices_test

namespace {

using choices_test::Metal;

static_assert(word_of(Metal::Tin) == "white-tin");
static_assert(choices_of(Metal{}).find("fe") == Metal::Iron);
static_assert(!choices_of(Metal{}).find("gold"));

TEST(Choices, EveryWordReadsAsTheValueThatWritesIt) {
  for (const Metal metal : {Metal::Iron, Metal::Copper, Metal::Tin})
    EXPECT_EQ(parse_choice<Metal>(word_of(metal)), metal);
}

TEST(Choices, AliasesAreReadAndNeverWritten) {
  EXPECT_EQ(parse_choice<Metal>("fe"), Metal::Iron);
  EXPECT_EQ(word_of(Metal::Iron), "iron");
  EXPECT_EQ(choice_words<Metal>(), (std::vector<std::string>{"copper", "iron", "white-tin"}));
  EXPECT_EQ(choice_values<Metal>(), (std::vector<Metal>{Metal::Copper, Metal::Iron, Metal::Tin}));
}

TEST(Choices, ErrorsNameTheWordAndListTheOthers) {
  for (const std::string& word : {std::string("gold"), std::string(), std::string("IRON")}) try {
      parse_choice<Metal>(word);
      ADD_FAILURE() << word;
    } catch (const InvalidInput& error) {
      EXPECT_EQ(error.what(), "'" + word + "' is no metal; choose one of copper, iron, white-tin");
    }
}

}  // namespace
}  // namespace batten
