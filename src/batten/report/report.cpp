#include "batten/report/report.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <utility>

#include "batten/core/text.hpp"

namespace batten {

namespace {

std::string escaped(const std::string& text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        if (static_cast<unsigned char>(c) >= 0x20 || c == '\n' || c == '\t') out += c;
    }
  }
  return out;
}

std::string number(double value, const char* format = "%.3g") {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string seconds(double value) {
  return value < 0.9995 ? concat(number(1000 * value), " ms") : concat(number(value), " s");
}

constexpr const char* kStyle = R"css(
:root{color-scheme:light dark;--paper:#fbfbfa;--card:#fff;--ink:#22262c;--soft:#5d6672;--line:#e1e4e8;--accent:#1c4a86;--bar:#4a78b8;--warn:#8f4a08;--good:#1d6b35;--bad:#b3261e;--warn-paper:#fdf3e3}
@media (prefers-color-scheme:dark){:root{--paper:#15181c;--card:#1d2126;--ink:#e6e8eb;--soft:#9aa4b0;--line:#30363d;--accent:#8fb8ea;--bar:#5c8ccb;--warn:#f0b56a;--good:#7fce97;--bad:#f2938c;--warn-paper:#2c2416}}
*{box-sizing:border-box}
body{margin:0;background:var(--paper);color:var(--ink);font:15px/1.5 system-ui,-apple-system,"Segoe UI",Roboto,"Helvetica Neue",sans-serif}
main{max-width:1120px;margin:0 auto;padding:2.2rem 1.4rem 3rem}
header{border-bottom:2px solid var(--accent);padding-bottom:.9rem;margin-bottom:1.4rem}
h1{font-size:1.75rem;line-height:1.2;margin:0;font-weight:650;letter-spacing:-.01em}
h2{font-size:1.08rem;margin:2.1rem 0 .7rem;font-weight:650}
header p{margin:.35rem 0 0;color:var(--soft);overflow-wrap:anywhere}
.pictures{display:grid;grid-template-columns:repeat(auto-fit,minmax(400px,1fr));gap:1rem}
figure{margin:0;background:var(--card);border:1px solid var(--line);border-radius:8px;overflow:hidden;break-inside:avoid}
figure.wide{grid-column:1/-1}
figure img{display:block;width:100%;height:auto;background:#fff}
figcaption{padding:.55rem .8rem .65rem;font-size:.88rem;color:var(--soft)}
figcaption b{color:var(--ink);font-weight:600}
.tables{display:grid;grid-template-columns:repeat(auto-fit,minmax(290px,1fr));gap:1rem}
.card{background:var(--card);border:1px solid var(--line);border-radius:8px;padding:.8rem 1rem;break-inside:avoid}
.card h3{margin:0 0 .4rem;font-size:.95rem;font-weight:600}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums}
td,th{text-align:left;padding:.26rem .5rem .26rem 0;border-top:1px solid var(--line);vertical-align:top;overflow-wrap:anywhere;font-weight:400}
tr:first-child td,tr:first-child th{border-top:0}
td.value{text-align:right;white-space:nowrap;font-weight:550}
td.unit{color:var(--soft);padding-right:0;width:40%}
.grid{overflow-x:auto;margin-bottom:1rem}.grid p{margin:.2rem 0 .6rem;color:var(--soft);font-size:.88rem}
.grid th{font-weight:600;border-top:0;vertical-align:bottom;overflow-wrap:normal}.grid td{white-space:nowrap}
.stages td{white-space:nowrap}
.stages td.bar{width:70%;padding-right:0}
.bar span{display:block;height:.95rem;background:var(--bar);border-radius:3px;min-width:2px;margin-top:.25rem;print-color-adjust:exact;-webkit-print-color-adjust:exact}
.mark{display:inline-block;font-size:.78rem;font-weight:600;border:1px solid var(--line);border-radius:999px;padding:.05rem .6rem;margin-left:.6rem;color:var(--soft);vertical-align:middle}
.mark.good{color:var(--good);border-color:var(--good)}.mark.bad{color:var(--bad);border-color:var(--bad)}
.facts{margin:0 0 1rem}.facts td:first-child{width:9rem;color:var(--soft)}
.plots .card{max-width:620px}
.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(400px,1fr));gap:1rem;margin-bottom:1rem}
svg .line{fill:none;stroke-width:2}.grid h3{margin:0 0 .2rem;font-size:.95rem;font-weight:600}
.warnings{background:var(--warn-paper);border:1px solid var(--warn);border-radius:8px;padding:.7rem 1rem .7rem 2.1rem;margin:0}
.warnings li{color:var(--warn);margin:.2rem 0;overflow-wrap:anywhere}
code,pre{font:13px/1.5 ui-monospace,SFMono-Regular,Menlo,Consolas,monospace}
pre{background:var(--card);border:1px solid var(--line);border-radius:8px;padding:.8rem 1rem;white-space:pre-wrap;overflow-wrap:anywhere;margin:0}
.options{columns:2 340px;column-gap:2rem;background:var(--card);border:1px solid var(--line);border-radius:8px;padding:.7rem 1rem}
.options div{display:flex;gap:.8rem;justify-content:space-between;border-bottom:1px solid var(--line);padding:.2rem 0;break-inside:avoid}
.options div b{font-weight:600;color:var(--accent)}
.options .set code::after{content:" set";color:var(--accent);font-size:.8em}
.options span{text-align:right;overflow-wrap:anywhere}
svg text{fill:var(--soft);font:12px system-ui,sans-serif}
svg .axis{stroke:var(--line)}svg .mark{stroke:var(--warn);stroke-dasharray:4 3}svg rect{fill:var(--bar)}
footer{margin-top:2.4rem;color:var(--soft);font-size:.85rem}
@media print{:root{--paper:#fff}body{font-size:11px}main{max-width:none;padding:0}.pictures{grid-template-columns:1fr 1fr}h2{break-after:avoid}}
)css";

void add_pictures(std::string& page, const std::vector<ReportPicture>& pictures) {
  if (pictures.empty()) return;
  page += "<div class=\"pictures\">\n";
  for (const ReportPicture& picture : pictures) {
    page += picture.wide || pictures.size() == 1 ? "<figure class=\"wide\">" : "<figure>";
    page += concat("<img alt=\"", escaped(picture.title), "\" src=\"data:image/png;base64,",
                   base64(picture.png), "\">");
    page += concat("<figcaption><b>", escaped(picture.title), "</b>");
    if (!picture.caption.empty()) page += concat(" ", escaped(picture.caption));
    page += "</figcaption></figure>\n";
  }
  page += "</div>\n";
}

void add_tables(std::string& page, const Report& report) {
  if (report.tables.empty()) return;
  page += "<section><h2>Figures</h2><div class=\"tables\">\n";
  for (const ReportTable& table : report.tables) {
    page += "<div class=\"card\">";
    if (!table.title.empty()) page += concat("<h3>", escaped(table.title), "</h3>");
    page += "<table>\n";
    for (const ReportFigure& figure : table.figures)
      page += concat("<tr><td>", escaped(figure.name), "</td><td class=\"value\">", escaped(figure.value),
                     "</td><td class=\"unit\">", escaped(figure.unit), "</td></tr>\n");
    page += "</table></div>\n";
  }
  page += "</div></section>\n";
}

void add_rows(std::string& page, const ReportGrid& grid) {
  if (!grid.note.empty()) page += concat("<p>", escaped(grid.note), "</p>");
  page += "<table>\n<tr>";
  for (const std::string& column : grid.columns) page += concat("<th>", escaped(column), "</th>");
  page += "</tr>\n";
  for (const std::vector<std::string>& row : grid.rows) {
    page += "<tr>";
    for (std::size_t i = 0; i < grid.columns.size(); ++i)
      page += concat("<td>", i < row.size() ? escaped(row[i]) : std::string(), "</td>");
    page += "</tr>\n";
  }
  page += "</table></div>";
}

void add_grids(std::string& page, const Report& report) {
  for (const ReportGrid& grid : report.grids) {
    page += concat("<section><h2>", escaped(grid.title), "</h2><div class=\"card grid\">");
    add_rows(page, grid);
    page += "</section>\n";
  }
}

/// A mark of an axis: as whole numbers from a thousand on, where three digits would become a power of ten.
std::string mark_text(double value) {
  return number(value, value >= 1000 && value < 1e6 ? "%.0f" : "%.3g");
}

/// A logarithmic axis over a range, from `begin` to `end` in the picture, with a mark at 1, 2 and 5 of every
/// decade, or at the decades alone where there are many.
class LogAxis {
 public:
  LogAxis(double low, double high, double begin, double end)
      : low_(std::log10(low)), high_(std::log10(high)), begin_(begin), end_(end) {
    if (high_ - low_ < 0.1) {
      low_ -= 0.1;
      high_ += 0.1;
    }
  }
  double operator()(double value) const {
    return begin_ + (end_ - begin_) * (std::log10(value) - low_) / (high_ - low_);
  }
  std::vector<double> marks() const {
    std::vector<double> found;
    for (int decade = static_cast<int>(std::floor(low_)); decade <= high_; ++decade)
      for (const double digit : {1.0, 2.0, 5.0}) {
        if (digit > 1 && high_ - low_ > 2.5) continue;
        const double place = decade + std::log10(digit);
        if (place >= low_ - 1e-9 && place <= high_ + 1e-9) found.push_back(digit * std::pow(10.0, decade));
      }
    return found;
  }

 private:
  double low_, high_, begin_, end_;
};

void add_plot(std::string& page, const ReportPlot& plot) {
  // Colours that are told apart on light and dark paper, and by those who see fewer of them.
  constexpr const char* kColours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"};
  constexpr double kWidth = 520, kHeight = 330, kLeft = 62, kRight = 12, kTop = 12, kBase = 285;
  const auto is_shown = [](const std::pair<double, double>& point) {
    return std::isfinite(point.first) && std::isfinite(point.second) && point.first > 0 && point.second > 0;
  };
  double x_low = 0, x_high = 0, y_low = 0, y_high = 0;
  const auto include = [](double value, double& low, double& high) {
    low = low > 0 ? std::min(low, value) : value;
    high = std::max(high, value);
  };
  for (const ReportLine& line : plot.lines)
    for (const auto& point : line.points)
      if (is_shown(point)) {
        include(point.first, x_low, x_high);
        include(point.second, y_low, y_high);
      }
  if (!(x_low > 0)) return;
  if (plot.level && plot.level->first > 0) include(plot.level->first, y_low, y_high);
  const LogAxis x(x_low, x_high, kLeft + 8, kWidth - kRight - 8), y(y_low / 1.1, y_high * 1.1, kBase, kTop);

  page += concat("<div class=\"card\"><h3>", escaped(plot.title), "</h3><svg viewBox=\"0 0 ", kWidth, " ",
                 kHeight + 18 * static_cast<double>(plot.lines.size()), "\" role=\"img\" aria-label=\"",
                 escaped(plot.title), "\">\n");
  for (const double mark : y.marks())
    page += concat("<line class=\"axis\" x1=\"", kLeft, "\" x2=\"", kWidth - kRight, "\" y1=\"", y(mark),
                   "\" y2=\"", y(mark), "\"/><text x=\"", kLeft - 6, "\" y=\"", y(mark) + 4,
                   "\" text-anchor=\"end\">", mark_text(mark), "</text>\n");
  for (const double mark : x.marks())
    page += concat("<line class=\"axis\" x1=\"", x(mark), "\" x2=\"", x(mark), "\" y1=\"", kTop, "\" y2=\"",
                   kBase, "\"/><text x=\"", x(mark), "\" y=\"", kBase + 17, "\" text-anchor=\"middle\">",
                   mark_text(mark), "</text>\n");
  if (plot.level && plot.level->first > 0)
    page += concat("<line class=\"mark\" x1=\"", kLeft, "\" x2=\"", kWidth - kRight, "\" y1=\"",
                   y(plot.level->first), "\" y2=\"", y(plot.level->first), "\"/><text x=\"", kLeft + 6,
                   "\" y=\"", y(plot.level->first) - 5, "\">", escaped(plot.level->second), "</text>\n");
  page += concat("<text x=\"", (kLeft + kWidth) / 2, "\" y=\"", kBase + 36, "\" text-anchor=\"middle\">",
                 escaped(plot.x), "</text><text transform=\"translate(13 ", (kTop + kBase) / 2,
                 ") rotate(-90)\" text-anchor=\"middle\">", escaped(plot.y), "</text>\n");
  std::size_t l = 0;
  for (const ReportLine& line : plot.lines) {
    const char* colour = kColours[l % std::size(kColours)];
    std::string path;
    for (const auto& point : line.points) {
      if (!is_shown(point)) continue;
      path += concat(path.empty() ? "M" : "L", x(point.first), " ", y(point.second), " ");
      page +=
          concat("<circle cx=\"", x(point.first), "\" cy=\"", y(point.second), "\" r=\"3\" fill=\"", colour,
                 "\"><title>", number(point.first), ": ", number(point.second), "</title></circle>\n");
    }
    const double legend = kHeight + 8 + 18 * static_cast<double>(l);
    page += concat("<path class=\"line\" stroke=\"", colour, "\" d=\"", path,
                   "\"/><path class=\"line\" stroke=\"", colour, "\" d=\"M", kLeft, " ", legend,
                   "h24\"/><text x=\"", kLeft + 32, "\" y=\"", legend + 4, "\">", escaped(line.name),
                   "</text>\n");
    ++l;
  }
  page += "</svg></div>\n";
}

void add_section(std::string& page, const ReportSection& section) {
  page += concat("<section><h2>", escaped(section.title));
  if (!section.mark.empty()) {
    const char* tone = section.tone == ReportTone::Good  ? " good"
                       : section.tone == ReportTone::Bad ? " bad"
                                                         : "";
    page += concat("<span class=\"mark", tone, "\">", escaped(section.mark), "</span>");
  }
  page += "</h2>\n";
  if (!section.figures.empty()) {
    page += "<div class=\"card facts\"><table>\n";
    for (const ReportFigure& figure : section.figures)
      page += concat("<tr><td>", escaped(figure.name), "</td><td>", escaped(figure.value),
                     figure.unit.empty() ? "" : " ", escaped(figure.unit), "</td></tr>\n");
    page += "</table></div>\n";
  }
  for (const ReportGrid& grid : section.grids) {
    page += "<div class=\"card grid\">";
    if (!grid.title.empty()) page += concat("<h3>", escaped(grid.title), "</h3>");
    add_rows(page, grid);
    page += "\n";
  }
  if (!section.plots.empty()) {
    page += "<div class=\"plots\">\n";
    for (const ReportPlot& plot : section.plots) add_plot(page, plot);
    page += "</div>\n";
  }
  add_pictures(page, section.pictures);
  page += "</section>\n";
}

void add_errors(std::string& page, const ReportErrors& errors) {
  std::vector<double> values;
  for (const double value : errors.values)
    if (std::isfinite(value)) values.push_back(value);
  if (values.empty()) return;
  double sum = 0, squares = 0;
  for (const double value : values) {
    sum += value;
    squares += value * value;
  }
  const auto n = static_cast<double>(values.size());
  std::sort(values.begin(), values.end());
  const double largest = values.back(), mean = sum / n;
  // The last bin takes the largest thousandth, so that one stray value does not squeeze the rest.
  const double smallest = std::min(0.0, values.front());
  double end = values[static_cast<std::size_t>(0.999 * (n - 1))];
  if (!(end > smallest)) end = largest > smallest ? largest : smallest + 1;
  constexpr int kBins = 48;
  std::vector<int> counts(kBins, 0);
  for (const double value : values)
    ++counts[std::clamp(static_cast<int>((value - smallest) / (end - smallest) * kBins), 0, kBins - 1)];
  const int most = *std::max_element(counts.begin(), counts.end());

  constexpr double kWidth = 1040, kHeight = 200, kLeft = 10, kBase = 170;
  const double step = (kWidth - 2 * kLeft) / kBins;
  page += concat("<section><h2>Distribution of the error</h2><div class=\"card\"><svg viewBox=\"0 0 ", kWidth,
                 " ", kHeight, "\" role=\"img\" aria-label=\"histogram of the error\">\n");
  for (int b = 0; b < kBins; ++b) {
    const double height = 150.0 * counts[b] / most;
    page += concat("<rect x=\"", kLeft + b * step + 1, "\" y=\"", kBase - height, "\" width=\"", step - 2,
                   "\" height=\"", height, "\"><title>", counts[b], "</title></rect>\n");
  }
  page += concat("<line class=\"axis\" x1=\"", kLeft, "\" x2=\"", kWidth - kLeft, "\" y1=\"", kBase,
                 "\" y2=\"", kBase, "\"/>\n");
  for (int t = 0; t <= 4; ++t) {
    const double x = kLeft + (kWidth - 2 * kLeft) * t / 4;
    page += concat("<text x=\"", x, "\" y=\"", kBase + 18, "\" text-anchor=\"",
                   t == 0   ? "start"
                   : t == 4 ? "end"
                            : "middle",
                   "\">", number(smallest + (end - smallest) * t / 4), "</text>\n");
  }
  const double mean_x = kLeft + (kWidth - 2 * kLeft) * std::min(1.0, (mean - smallest) / (end - smallest));
  page += concat("<line class=\"mark\" x1=\"", mean_x, "\" x2=\"", mean_x, "\" y1=\"12\" y2=\"", kBase,
                 "\"/><text x=\"", mean_x + 5, "\" y=\"14\">mean</text>\n</svg>");
  page += concat("<p>",
                 escaped(concat(values.size(), " values in ", errors.unit, ": mean ", number(mean), ", rms ",
                                number(std::sqrt(squares / n)), ", median ",
                                number(values[values.size() / 2]), ", largest ", number(largest), ".")),
                 "</p></div></section>\n");
}

void add_times(std::string& page, const StageTimes& times) {
  if (times.stages().empty()) return;
  double longest = 0;
  for (const auto& [stage, time] : times.stages()) longest = std::max(longest, time);
  page += concat("<section><h2>Time, ", escaped(seconds(times.total())),
                 " in all</h2><div class=\"card\"><table class=\"stages\">\n");
  for (const auto& [stage, time] : times.stages())
    page += concat("<tr><td>", escaped(stage), "</td><td class=\"value\">", escaped(seconds(time)),
                   "</td><td class=\"bar\"><span style=\"width:",
                   number(longest > 0 ? 100 * time / longest : 0, "%.1f"), "%\"></span></td></tr>\n");
  page += "</table></div></section>\n";
}

void add_options(std::string& page, const std::vector<ReportOption>& options) {
  if (options.empty()) return;
  page += "<section><h2>Options</h2><div class=\"options\">\n";
  for (const ReportOption& option : options) {
    const std::string value = option.value.empty() ? "–" : escaped(option.value);
    page += option.is_default
                ? concat("<div><code>", escaped(option.name), "</code><span>", value, "</span></div>\n")
                : concat("<div class=\"set\"><code>", escaped(option.name), "</code><span><b>", value,
                         "</b></span></div>\n");
  }
  page += "</div></section>\n";
}

}  // namespace

std::string base64(const std::string& bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (k < n ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += k <= n ? kDigits[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string html(const Report& report) {
  std::string page = concat(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>",
      escaped(report.title), report.subject.empty() ? "" : ": ", escaped(report.subject), "</title>\n<style>",
      kStyle, "</style>\n</head>\n<body>\n<main>\n<header><h1>", escaped(report.title), "</h1>");
  if (!report.subject.empty()) page += concat("<p>", escaped(report.subject), "</p>");
  page += "</header>\n";
  if (!report.warnings.empty()) {
    page += "<section><h2>Warnings</h2><ul class=\"warnings\">\n";
    for (const std::string& warning : report.warnings) page += concat("<li>", escaped(warning), "</li>\n");
    page += "</ul></section>\n";
  }
  add_grids(page, report);
  if (!report.pictures.empty()) {
    page += "<section><h2>Pictures</h2>";
    add_pictures(page, report.pictures);
    page += "</section>\n";
  }
  add_tables(page, report);
  for (const ReportSection& section : report.sections) add_section(page, section);
  if (report.errors) add_errors(page, *report.errors);
  add_times(page, report.times);
  add_options(page, report.options);
  if (!report.command_line.empty())
    page += concat("<section><h2>To repeat</h2><pre>", escaped(report.command_line), "</pre></section>\n");
  page +=
      concat("<footer>Written by Batten ", escaped(report.version), "</footer>\n</main>\n</body>\n</html>\n");
  return page;
}

}  // namespace batten
