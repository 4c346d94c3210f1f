#pragma once
#include "thesis_run.hpp"

#include "batten/report/report.hpp"

namespace batten::experiments {

/// All rows as one table: verdict, id, claim, figures of the thesis and ours.
ReportGrid rows_grid(const ThesisResult& result);

/// Adds to a page the table of rows and a section for each row: what the thesis claims, ours, data, what is
/// missing, tables, plots and pictures. Rows that are still to come are named in the warnings.
void add_rows(const ThesisResult& result, Report& page);

/// How many rows there are of each verdict, a sentence: "40 rows: 12 pass, 3 fail, …".
std::string counts_sentence(const VerdictCounts& counts);

}  // namespace batten::experiments
