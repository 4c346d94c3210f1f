#include "thesis_page.hpp"

#include <utility>

#include "batten/core/text.hpp"

namespace batten::experiments {

namespace {

ReportTone tone_of(const ThesisRow& row) {
  if (row.is_missed()) return ReportTone::Bad;
  return row.verdict == Verdict::Pass || (row.holds && *row.holds) ? ReportTone::Good : ReportTone::Neutral;
}

ReportSection section_of(const ThesisRow& row) {
  ReportSection section;
  section.title = row.id;
  section.mark = verdict_text(row);
  section.tone = tone_of(row);
  const auto fact = [&](const char* name, std::string value) {
    if (!value.empty()) section.figures.push_back({name, std::move(value), ""});
  };
  fact("claim", row.claim);
  fact("thesis", row.thesis.is_null() ? "" : figures_text(row.thesis));
  fact("ours", row.ours.is_null() ? "" : figures_text(row.ours));
  fact("data", row.data);
  fact("needs", row.needs);
  fact("reading", row.remark);
  section.grids = row.grids;
  section.plots = row.plots;
  section.pictures = row.pictures;
  return section;
}

}  // namespace

ReportGrid rows_grid(const ThesisResult& result) {
  ReportGrid grid;
  grid.title = "Rows";
  grid.note = counts_sentence(verdict_counts(result.rows));
  grid.columns = {"row", "verdict", "thesis", "ours"};
  for (const ThesisRow& row : result.rows)
    grid.rows.push_back({row.id, verdict_text(row), row.thesis.is_null() ? "–" : figures_text(row.thesis),
                         row.ours.is_null() ? "–" : figures_text(row.ours)});
  return grid;
}

void add_rows(const ThesisResult& result, Report& page) {
  ReportGrid grid = rows_grid(result);
  // Figures stand in the sections, where they have the room.
  grid.columns = {"row", "verdict", "claim"};
  for (std::size_t i = 0; i < result.rows.size(); ++i)
    grid.rows[i] = {result.rows[i].id, verdict_text(result.rows[i]), result.rows[i].claim};
  for (const std::string& id : result.to_come) grid.rows.push_back({id, "to come", ""});
  page.grids.push_back(std::move(grid));
  for (const ThesisRow& row : result.rows) page.sections.push_back(section_of(row));
  page.warnings.insert(page.warnings.end(), result.warnings.begin(), result.warnings.end());
  if (!result.to_come.empty())
    page.warnings.insert(page.warnings.begin(),
                         concat("not finished: rows to come: ", result.to_come.size()));
  page.times = result.times;
}

std::string counts_sentence(const VerdictCounts& counts) {
  int total = 0;
  std::string list;
  for (const Verdict verdict : choice_values<Verdict>()) {
    const int n = counts.verdicts[static_cast<std::size_t>(verdict)];
    total += n;
    list += concat(list.empty() ? "" : ", ", n, " ", word_of(verdict));
    if (verdict == Verdict::StandIn)
      list += concat(" (", counts.stand_in_pass, " pass, ", counts.stand_in_fail, " fail, ",
                     counts.stand_in_shown, " shown)");
  }
  return concat(total, " rows: ", list, ".");
}

}  // namespace batten::experiments
