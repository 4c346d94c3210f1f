#pragma once
#include <functional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/report/report.hpp"

namespace batten::experiments {

/// The tables of H that can be repeated: "2.2" fairing, "2.3" remeshing, "2.4" and "2.5" simplification.
const std::vector<std::string>& thesis_h_tables();

/// What thesis_h() found.
struct ThesisTables {
  std::vector<ReportGrid> grids;
  std::vector<ReportPicture> pictures;
  nlohmann::ordered_json tables =
      nlohmann::ordered_json::object();  ///< per table a list of rows: what H prints and what was measured
  nlohmann::ordered_json meshes = nlohmann::ordered_json::object();  ///< per mesh at hand its file and counts
  std::vector<std::string> missing;
  std::vector<std::string> warnings;
  StageTimes times;
};

/// Called after every table with all that was found so far, the last table at the end.
using TableDone = std::function<void(const ThesisTables&)>;

/// Repeats the experiments of H chapter 2 on those of its meshes that lie in `folder` or in its folder
/// "meshes", under their names (fandisk.obj, igea.ply.gz, …). The methods are called as `batten fair`,
/// `remesh` and `simplify` do. A mesh that a method refuses leaves its places empty, with a warning.
/// @param folder empty: no mesh is at hand.
/// @param tables of thesis_h_tables().
/// @throws FileError when a mesh cannot be read; Cancelled.
ThesisTables thesis_h(const std::string& folder, const std::vector<std::string>& tables, bool pictures,
                      const Progress& progress, const TableDone& done = {});

}  // namespace batten::experiments
