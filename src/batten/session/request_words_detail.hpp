#pragma once
#include "batten/core/choices.hpp"
#include "batten/session/request.hpp"

// Private to the room: words in journals for enumerations that have none beside them.
namespace batten {

constexpr auto journal_choices_of(Length::Kind) {
  return choices<Length::Kind>("kind of length", {{Length::Kind::Plain, "plain"},
                                                  {Length::Kind::Metres, "metres"},
                                                  {Length::Kind::Relative, "relative"}});
}
constexpr auto journal_choices_of(WeightChoice) {
  return choices<WeightChoice>(
      "choice of weights",
      {{WeightChoice::Auto, "auto"}, {WeightChoice::Thesis, "thesis"}, {WeightChoice::Given, "given"}});
}

}  // namespace batten
