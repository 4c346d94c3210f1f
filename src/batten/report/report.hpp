#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "batten/core/stage_times.hpp"

namespace batten {

/// A picture of a report.
struct ReportPicture {
  std::string title;    ///< "isophotes"
  std::string caption;  ///< what to see in it, a sentence; may be empty
  std::string png;      ///< the bytes of a PNG file
  bool wide = false;    ///< takes the whole width
};

/// A number or word with its name: {"mean error", "0.007", "% of the diameter"}.
struct ReportFigure {
  std::string name, value, unit;
};
/// Figures under a heading: "Network", "Surface".
struct ReportTable {
  std::string title;
  std::vector<ReportFigure> figures;
};

/// A table with a heading over every column, for experiments with many cases.
struct ReportGrid {
  std::string title;                           ///< "Table 2.3: remeshing"
  std::string note;                            ///< below the title, what the columns mean; may be empty
  std::vector<std::string> columns;            ///< the headings
  std::vector<std::vector<std::string>> rows;  ///< one entry per column; missing ones stay empty
};

/// A line of a plot with its marks. Points with a coordinate that is not a positive number are left out.
struct ReportLine {
  std::string name;
  std::vector<std::pair<double, double>> points;
};

/// Lines over two logarithmic axes: how an error falls with a step.
struct ReportPlot {
  std::string title;
  std::string x, y;               ///< what the axes are, with their units
  std::vector<ReportLine> lines;  ///< told apart by colour and name
  /// A value of y that is drawn across, with its name: what somebody else has reached.
  std::optional<std::pair<double, std::string>> level;
};

/// How a section ended, for the colour of its mark.
enum class ReportTone { Neutral, Good, Bad };

/// A part of a report with a heading of its own.
struct ReportSection {
  std::string title;
  std::string mark;  ///< a word beside the title: "pass"; may be empty
  ReportTone tone = ReportTone::Neutral;
  std::vector<ReportFigure> figures;  ///< name and value one below the other; the unit follows the value
  std::vector<ReportGrid> grids;
  std::vector<ReportPlot> plots;
  std::vector<ReportPicture> pictures;
};

/// An option of the run.
struct ReportOption {
  std::string name, value;
  bool is_default = true;
};

/// Distances to a truth, drawn as a histogram.
struct ReportErrors {
  Eigen::VectorXd values;  ///< values that are not finite are left out
  std::string unit;        ///< "% of the diameter"
};

/// Everything a report shows; empty parts are left out.
struct Report {
  std::string title;         ///< "batten reconstruct"
  std::string subject;       ///< the file it is about
  std::string version;       ///< of the program
  std::string command_line;  ///< to repeat the run
  std::vector<ReportPicture> pictures;
  std::vector<ReportGrid> grids;
  std::vector<ReportTable> tables;
  std::vector<ReportSection> sections;
  std::optional<ReportErrors> errors;
  std::vector<std::string> warnings;  ///< in words
  StageTimes times;
  std::vector<ReportOption> options;
};

/// One HTML page that needs no other file and no network: pictures inside, light and dark, ready to print.
/// Any text may stand in the fields; it is escaped. The page says the same for the same report.
std::string html(const Report& report);

/// Bytes as base64 (RFC 4648) with padding.
std::string base64(const std::string& bytes);

}  // namespace batten
