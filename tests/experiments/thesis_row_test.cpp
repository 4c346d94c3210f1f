#include "experiments/thesis_row.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace batten::experiments {
namespace {

ThesisRow row_of(const std::string& id) {
  ThesisRow row;
  row.id = id;
  row.claim = "A claim.";
  return row;
}

/// One of each kind that there is.
std::vector<ThesisRow> rows_of_every_kind() {
  std::vector<ThesisRow> rows(7);
  rows[0].decide(true);
  rows[1].decide(false);
  rows[2].verdict = Verdict::Shown;
  rows[3].stand_in(true);
  rows[4].stand_in(false);
  rows[5].stand_in(std::nullopt);
  rows[6].needs = "a file";
  return rows;
}

// Known answers: the seven kinds of the list above, in its order.
TEST(ThesisRow, HasAVerdictOfEachKind) {
  const std::vector<ThesisRow> rows = rows_of_every_kind();
  const char* texts[] = {"pass",   "fail", "shown", "stand-in: pass", "stand-in: fail", "stand-in: shown",
                         "no-data"};
  const bool missed[] = {false, true, false, false, true, false, false};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(verdict_text(rows[i]), texts[i]);
    EXPECT_EQ(rows[i].is_missed(), missed[i]) << texts[i];
  }
}

TEST(ThesisRow, IsCountedOnceWhateverItsKind) {
  std::vector<ThesisRow> rows = rows_of_every_kind();
  rows.push_back(rows[0]);
  const VerdictCounts counts = verdict_counts(rows);
  const int expected[] = {2, 1, 1, 3, 1};  // pass, fail, shown, stand-in, no-data
  for (std::size_t i = 0; i < counts.verdicts.size(); ++i) EXPECT_EQ(counts.verdicts[i], expected[i]) << i;
  EXPECT_EQ(counts.stand_in_pass, 1);
  EXPECT_EQ(counts.stand_in_fail, 1);
  EXPECT_EQ(counts.stand_in_shown, 1);
  EXPECT_EQ(counts.misses(), 2) << "a row that fails and a stand-in that does";
  EXPECT_EQ(verdict_counts({}).misses(), 0);
  const Json json = counts_json(counts);
  EXPECT_EQ(
      json.dump(),
      R"({"pass":2,"fail":1,"shown":1,"stand-in":3,"no-data":1,"stand_ins":{"pass":1,"fail":1,"shown":1}})");
}

TEST(ThesisRow, IsWrittenWithNullWhereThereIsNothing) {
  ThesisRow row = row_of("S 3.18");
  EXPECT_EQ(row_json(row).dump(),
            R"({"id":"S 3.18","claim":"A claim.","thesis":null,"ours":null,"verdict":"no-data","holds":null,)"
            R"("data":null,"needs":null,"remark":null,"timed":false})");
  row.thesis = {{"mean_percent", 0.4}};
  row.ours = {{"mean_percent", 0.05}};
  row.data = "seeds 1–20";
  row.needs = "the recording";
  row.remark = "A remark.";
  row.is_timed = true;
  row.stand_in(true);
  EXPECT_EQ(
      row_json(row).dump(),
      R"({"id":"S 3.18","claim":"A claim.","thesis":{"mean_percent":0.4},"ours":{"mean_percent":0.05},)"
      R"("verdict":"stand-in","holds":true,"data":"seeds 1–20","needs":"the recording","remark":"A remark.",)"
      R"("timed":true})");
}

TEST(FiguresText, TakesUnitsFromTheEndsOfNames) {
  EXPECT_EQ(figures_text({{"mean_percent", 0.4}, {"steps", 3}, {"sound", true}}),
            "mean 0.4 %, steps 3, sound yes");
  EXPECT_EQ(figures_text({{"normals_deg", 12.34}, {"all_ms", {1, 2.5}}, {"box_m", {1.0, 0.25}}}),
            "normals 12.3°, all 1 / 2.5 ms, box 1 / 0.25 m");
  EXPECT_EQ(
      figures_text({{"network", {{"median_percent", 1}, {"worst_percent", nullptr}}}, {"better", "λ = 1"}}),
      "network (median 1 %, worst –), better λ = 1");
  EXPECT_EQ(figures_text({{"_percent", 1}}), " percent 1") << "a unit needs a name before it";
}

TEST(SpreadOf, IsMedianAndLargest) {
  const Spread spread = spread_of({3, 1, NAN, 10, 2});
  EXPECT_EQ(spread.median, 2.5);
  EXPECT_EQ(spread.worst, 10);
  EXPECT_TRUE(std::isnan(spread_of({}).median));
  EXPECT_TRUE(std::isnan(spread_of({NAN}).worst)) << "where nothing was measured nothing can hold";
  EXPECT_EQ(number(NAN), "–");
}

}  // namespace
}  // namespace batten::experiments
