#include "thesis_row.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string_view>
#include <utility>

#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"

namespace batten::experiments {

namespace {

Json text_or_null(const std::string& text) {
  return text.empty() ? Json(nullptr) : Json(text);
}

constexpr std::pair<std::string_view, std::string_view> kUnits[] = {
    {"_percent", " %"}, {"_deg", "°"}, {"_ms", " ms"}, {"_mm", " mm"}, {"_s", " s"}, {"_m", " m"}};

std::string value_text(const Json& value, std::string_view unit) {
  if (value.is_null()) return "–";
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_integer()) return concat(value.get<long>(), unit);
  if (value.is_number()) return number(value.get<double>()) + std::string(unit);
  if (value.is_string()) return value.get<std::string>();
  if (value.is_array()) {
    std::string text;
    for (const Json& entry : value) text += (text.empty() ? "" : " / ") + value_text(entry, "");
    return text + std::string(unit);
  }
  return figures_text(value);
}

}  // namespace

std::string number(double value, const char* format) {
  if (!std::isfinite(value)) return "–";
  // Three digits of a thousand would be written as a power of ten.
  if (std::string_view(format) == "%.3g" && std::abs(value) >= 1000 && std::abs(value) < 1e6) format = "%.0f";
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string verdict_text(const ThesisRow& row) {
  const std::string word(word_of(row.verdict));
  if (row.verdict != Verdict::StandIn) return word;
  return concat(word, ": ", !row.holds ? "shown" : *row.holds ? "pass" : "fail");
}

Json row_json(const ThesisRow& row) {
  Json json = {{"id", row.id},
               {"claim", row.claim},
               {"thesis", row.thesis},
               {"ours", row.ours},
               {"verdict", word_of(row.verdict)},
               {"holds", nullptr},
               {"data", text_or_null(row.data)},
               {"needs", text_or_null(row.needs)},
               {"remark", text_or_null(row.remark)},
               {"timed", row.is_timed}};
  if (row.holds) json["holds"] = *row.holds;
  return json;
}

VerdictCounts verdict_counts(const std::vector<ThesisRow>& rows) {
  VerdictCounts counts;
  for (const ThesisRow& row : rows) {
    ++counts.verdicts[static_cast<std::size_t>(row.verdict)];
    if (row.verdict != Verdict::StandIn) continue;
    ++(!row.holds ? counts.stand_in_shown : *row.holds ? counts.stand_in_pass : counts.stand_in_fail);
  }
  return counts;
}

Json counts_json(const VerdictCounts& counts) {
  Json json = Json::object();
  for (const Verdict verdict : choice_values<Verdict>())
    json[std::string(word_of(verdict))] = counts.verdicts[static_cast<std::size_t>(verdict)];
  json["stand_ins"] = {
      {"pass", counts.stand_in_pass}, {"fail", counts.stand_in_fail}, {"shown", counts.stand_in_shown}};
  return json;
}

std::string figures_text(const Json& figures) {
  if (!figures.is_object()) return value_text(figures, "");
  std::string text;
  for (const auto& [key, value] : figures.items()) {
    std::string name = key;
    std::string_view unit;
    for (const auto& [ending, written] : kUnits)
      if (name.size() > ending.size() && name.ends_with(ending)) {
        name.resize(name.size() - ending.size());
        unit = written;
        break;
      }
    std::replace(name.begin(), name.end(), '_', ' ');
    const std::string written = value_text(value, unit);
    text += concat(text.empty() ? "" : ", ", name,
                   value.is_object() ? concat(" (", written, ")") : " " + written);
  }
  return text;
}

Spread spread_of(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) {
    const double none = std::numeric_limits<double>::quiet_NaN();
    return {none, none};
  }
  return {median(values), *std::max_element(values.begin(), values.end())};
}

}  // namespace batten::experiments
