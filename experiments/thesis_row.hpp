#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "batten/core/choices.hpp"
#include "batten/report/report.hpp"

namespace batten::experiments {

using Json = nlohmann::ordered_json;

/// How a claim of a thesis fares.
enum class Verdict {
  Pass,     ///< the thesis states a number or an order, its data are at hand or a formula, and ours holds it
  Fail,     ///< the same, and ours does not
  Shown,    ///< the thesis has a picture or a plot alone: ours beside it, nothing decided
  StandIn,  ///< its data are not public, others of the same dimensions take their place: see Decision
  NoData,   ///< nothing can stand in
};

constexpr auto choices_of(Verdict) {
  return choices<Verdict>("verdict", {{Verdict::Pass, "pass"},
                                      {Verdict::Fail, "fail"},
                                      {Verdict::Shown, "shown"},
                                      {Verdict::StandIn, "stand-in"},
                                      {Verdict::NoData, "no-data"}});
}

/// One claim of a thesis and what became of it.
struct ThesisRow {
  std::string id;     ///< "S 3.18"; what comes after the number tells rows of one figure apart
  std::string claim;  ///< a sentence
  Json thesis;        ///< the figures that the thesis prints, by name; null where it prints none
  Json ours;          ///< ours; null where there are none
  Verdict verdict = Verdict::NoData;
  /// Of a stand-in: whether the claim holds on it; nothing where there is nothing to decide.
  std::optional<bool> holds;
  std::string data;    ///< the files, formulas or seeds that ours come from; empty without
  std::string needs;   ///< what would close the row; empty where nothing is missing
  std::string remark;  ///< our reading, a sentence; may be empty
  /// Decided by times of this machine: it may end otherwise elsewhere.
  bool is_timed = false;
  std::vector<ReportGrid> grids;
  std::vector<ReportPlot> plots;
  std::vector<ReportPicture> pictures;

  /// The thesis's own data, or a formula that it names: Pass or Fail.
  void decide(bool claim_holds) { verdict = claim_holds ? Verdict::Pass : Verdict::Fail; }
  /// Other data of the same dimensions.
  void stand_in(std::optional<bool> claim_holds) {
    verdict = Verdict::StandIn;
    holds = claim_holds;
  }
  /// Whether the claim was decided against us, on the thesis's data or on others.
  bool is_missed() const { return verdict == Verdict::Fail || (holds && !*holds); }
};

/// The verdict in words: "pass", or of a stand-in "stand-in: pass", "stand-in: fail", "stand-in: shown".
std::string verdict_text(const ThesisRow& row);

/// id, claim, thesis, ours, verdict, holds, data, needs, remark; null where there is nothing.
Json row_json(const ThesisRow& row);

/// How many rows there are of each verdict, and of the stand-ins how many hold, fail and are shown.
struct VerdictCounts {
  std::array<int, 5> verdicts{};  ///< in the order of Verdict
  int stand_in_pass = 0, stand_in_fail = 0, stand_in_shown = 0;

  int misses() const { return verdicts[static_cast<std::size_t>(Verdict::Fail)] + stand_in_fail; }
};
VerdictCounts verdict_counts(const std::vector<ThesisRow>& rows);
Json counts_json(const VerdictCounts& counts);

/// Figures in words, for a table: {"mean_percent": 0.4, "steps": 3} → "mean 0.4 %, steps 3". Names end in
/// their unit: _percent, _deg, _ms, _s, _mm, _m.
std::string figures_text(const Json& figures);

/// Median and worst (largest) of some values, finite ones alone. NaN without any.
struct Spread {
  double median = 0, worst = 0;
};
Spread spread_of(std::vector<double> values);

/// A number with three significant digits, or by a format of printf.
std::string number(double value, const char* format = "%.3g");

}  // namespace batten::experiments
