#include "batten/report/report.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace batten {
namespace {

Report full_report() {
  Report report;
  report.title = "batten reconstruct";
  report.subject = "scan.rawnet";
  report.version = "1.2.3";
  report.command_line = "batten reconstruct scan.rawnet -o surface.ply";
  report.pictures = {{"shaded", "A sentence.", "\x89PNG", false}, {"isophotes", "", "\x89PNG", true}};
  report.tables = {{"Surface", {{"vertices", "1234", ""}, {"mean error", "0.007", "% of the diameter"}}}};
  report.errors = ReportErrors{Eigen::VectorXd::LinSpaced(100, 0, 1), "%"};
  report.warnings = {"the curve 3 ends at no node"};
  report.times.add("regression", 0.25);
  report.times.add("surface", 1.5);
  report.options = {{"step", "1.6%", true}, {"weights", "0.1,1e-3", false}};
  ReportSection section;
  section.title = "S 3.18";
  section.mark = "pass";
  section.tone = ReportTone::Good;
  section.figures = {{"claim", "The mean is small.", ""}, {"ours", "0.05", "%"}};
  section.grids = {{"Steps", "", {"h", "mean"}, {{"6.4", "0.1"}}}};
  section.plots = {{"Error", "h, %", "mean, %", {{"ours", {{6.4, 0.1}, {3.2, 0.01}}}}, {{0.4, "S"}}}};
  section.pictures = {{"the cone", "", "\x89PNG", false}};
  report.sections = {section};
  return report;
}

int count(const std::string& text, const std::string& part) {
  int n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

// Test vectors of RFC 4648, section 10.
TEST(Base64, AgreesWithTheStandard) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xff\xfe"), "//4=");
}

TEST(Report, SaysEverythingThatItWasGiven) {
  const std::string page = html(full_report());
  for (const char* part : {"batten reconstruct",
                           "scan.rawnet",
                           "1.2.3",
                           "isophotes",
                           "A sentence.",
                           "1234",
                           "0.007",
                           "% of the diameter",
                           "the curve 3 ends at no node",
                           "regression",
                           "250 ms",
                           "1.5 s",
                           "1.75 s in all",
                           "weights",
                           "0.1,1e-3",
                           "1.6%",
                           "data:image/png;base64,iVBORw==",
                           "S 3.18",
                           "mark good\">pass<",
                           "The mean is small.",
                           "0.05 %",
                           "Steps",
                           "mean, %",
                           "the cone"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
  EXPECT_EQ(count(page, "<img "), 3);
}

// Three columns, a row of three and one of one: two rows of three cells, the missing ones empty.
TEST(Report, DrawsGridsWithAHeadingPerColumn) {
  Report report;
  report.grids = {{"Table 1", "A < B", {"mesh", "ours", "theirs"}, {{"cow", "1", "2"}, {"cat & dog"}}}};
  const std::string page = html(report);
  EXPECT_EQ(count(page, "<th>"), 3);
  EXPECT_EQ(count(page, "<td>"), 6);
  EXPECT_EQ(count(page, "<td></td>"), 2);
  for (const char* part : {"<h2>Table 1</h2>", "A &lt; B", "<th>theirs</th>", "<td>cat &amp; dog</td>"})
    EXPECT_NE(page.find(part), std::string::npos) << part;
}

// A straight line over logarithmic axes stays one: y ∝ x² through three points whose x are evenly apart in
// the logarithm; equal steps in the picture. What cannot be drawn there is left out.
TEST(Report, PlotsOverLogarithmicAxes) {
  Report report;
  report.sections.emplace_back();
  report.sections[0].plots = {
      {"", "h", "error", {{"ours", {{1, 1}, {10, 100}, {100, 1e4}, {0, 5}, {5, NAN}}}}, {}}};
  const std::string page = html(report);
  std::vector<std::pair<double, double>> centres;
  for (std::size_t at = page.find("<circle cx=\""); at != std::string::npos;
       at = page.find("<circle cx=\"", at + 1)) {
    const std::size_t y = page.find("cy=\"", at);
    centres.emplace_back(std::stod(page.substr(at + 12)), std::stod(page.substr(y + 4)));
  }
  ASSERT_EQ(centres.size(), 3U);
  EXPECT_GT(centres[1].first, centres[0].first);
  EXPECT_LT(centres[1].second, centres[0].second) << "larger values stand higher";
  EXPECT_NEAR(centres[2].first - centres[1].first, centres[1].first - centres[0].first, 0.01);
  EXPECT_NEAR(centres[2].second - centres[1].second, centres[1].second - centres[0].second, 0.01);
  // A level below all points is in the picture too.
  report.sections[0].plots[0].level = {0.01, "theirs"};
  EXPECT_NE(html(report).find(">theirs</text>"), std::string::npos);
  report.sections[0].plots[0].lines.clear();
  EXPECT_EQ(html(report).find("<svg"), std::string::npos) << "nothing to plot";
}

// A page that works offline: nothing is fetched, nothing runs.
TEST(Report, NeedsNoOtherFile) {
  const std::string page = html(full_report());
  for (const char* part : {"http:", "https:", "<script", "<link", "@import", "url("})
    EXPECT_EQ(page.find(part), std::string::npos) << part;
}

TEST(Report, EscapesWhateverStandsInTheFields) {
  Report report = full_report();
  report.title = "<script>alert('x')</script> & \"more\"";
  report.warnings = {"</ul><b>"};
  report.options = {{"<o>", "<v>", false}};
  report.pictures[0].title = "\"><b>";
  const std::string page = html(report);
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_EQ(page.find("</ul><b>"), std::string::npos);
  EXPECT_EQ(page.find("<o>"), std::string::npos);
  EXPECT_EQ(page.find("\"\"><b>"), std::string::npos);
  EXPECT_NE(page.find("&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt; &amp; &quot;more&quot;"),
            std::string::npos);
}

// Every element that is opened is closed.
TEST(Report, IsWellFormed) {
  for (const Report& report : {full_report(), Report{}}) {
    const std::string page = html(report);
    for (const std::string tag :
         {"html",       "head", "body", "main", "section", "figure", "table",  "tr",
          "td",         "div",  "ul",   "li",   "svg",     "pre",    "header", "footer",
          "figcaption", "h2",   "p",    "code", "span",    "h3",     "text",   "title"}) {
      EXPECT_EQ(count(page, "<" + tag + ">") + count(page, "<" + tag + " "), count(page, "</" + tag + ">"))
          << tag;
    }
  }
}

// The heights of the bars of the histogram add up to the number of values.
TEST(Report, CountsEveryFiniteErrorOnce) {
  Report report;
  Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(480, 0, 1);
  values[7] = NAN;
  report.errors = ReportErrors{values, "mm"};
  const std::string page = html(report);
  int total = 0;
  for (std::size_t at = page.find("<title>", page.find("<svg")); at != std::string::npos;
       at = page.find("<title>", at + 1))
    total += std::stoi(page.substr(at + 7));
  EXPECT_EQ(total, 479);
  EXPECT_NE(page.find("479 values in mm"), std::string::npos);
}

TEST(Report, SurvivesErrorsThatAreAllEqualOrMissing) {
  Report report;
  report.errors = ReportErrors{Eigen::VectorXd::Zero(10), "mm"};
  EXPECT_NE(html(report).find("10 values"), std::string::npos);
  EXPECT_EQ(html(report).find("nan"), std::string::npos);
  report.errors = ReportErrors{Eigen::VectorXd::Constant(3, NAN), "mm"};
  EXPECT_EQ(html(report).find("<svg"), std::string::npos);
  report.errors = ReportErrors{Eigen::VectorXd(0), "mm"};
  EXPECT_EQ(html(report).find("<svg"), std::string::npos);
}

}  // namespace
}  // namespace batten
