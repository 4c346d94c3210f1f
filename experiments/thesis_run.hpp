#pragma once
#include "thesis_row.hpp"

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "batten/core/parallel.hpp"
#include "batten/core/progress.hpp"
#include "batten/core/stage_times.hpp"
#include "batten/mesh/triangle_mesh.hpp"
#include "batten/render/render.hpp"

namespace batten::experiments {

/// How the rows of a thesis are made.
struct ThesisOptions {
  std::string data = {};      ///< folder with the public meshes and curves; empty: none
  std::string sessions = {};  ///< folder with the sessions of sketches; empty: none
  bool quick = false;         ///< five seeds instead of twenty, fewer steps, small meshes
  bool pictures = false;
  /// Only rows whose id, with or without the letter of the thesis, begins with one of these; empty: all.
  std::vector<std::string> rows = {};
};

class ThesisRun;

/// Work that makes some rows together.
struct ThesisExperiment {
  std::vector<std::string> ids;  ///< of its rows, all of which it adds
  std::function<void(ThesisRun&)> work;
};

/// What was found so far.
struct ThesisResult {
  std::vector<ThesisRow> rows;       ///< in the order of the thesis
  std::vector<std::string> to_come;  ///< ids
  std::vector<std::string> warnings;
  StageTimes times;
};

/// Called after every experiment with all rows there are.
using RowsDone = std::function<void(const ThesisResult&)>;

/// Runs experiments and keeps their rows.
class ThesisRun {
 public:
  ThesisRun(const ThesisOptions& options, const Progress& progress);

  /// Runs them one after the other. A refusal (Error) inside one makes its missing rows fail, with the
  /// sentence. The rows come in the order of the numbers in their ids, those of one number as given.
  /// @throws FileError when a file that is there cannot be read; Cancelled.
  ThesisResult run(const std::vector<ThesisExperiment>& experiments, const RowsDone& done);

  const ThesisOptions options;
  int n_seeds() const { return options.quick ? 5 : 20; }
  std::string seeds_text(std::string_view what) const;

  /// Adds a row; those that were not asked for are dropped.
  void add(ThesisRow row);
  /// Whether a row is asked for: what only serves others can be left out.
  bool wants(const std::string& id) const;
  /// The path of a file in the folder of public data, also packed (.gz); nothing where it is not there.
  std::optional<std::string> file(const std::string& name) const;
  /// A mesh of the folder `meshes`, read once, under one of the usual endings and spellings; null where it is
  /// not there. @param path if given, receives where it was.
  const TriangleMesh* mesh(const std::string& name, std::string* path = nullptr);

  /// work(seed) for the seeds 1 … n_seeds(), on all processors; the results in the order of the seeds.
  template <typename Work>
  auto for_seeds(Work&& work) {
    std::vector<decltype(work(1))> results(static_cast<std::size_t>(n_seeds()));
    parallel_for(
        n_seeds(), 1,
        [&](Eigen::Index begin, Eigen::Index end) {
          for (Eigen::Index i = begin; i < end; ++i)
            results[static_cast<std::size_t>(i)] = work(static_cast<int>(i) + 1);
        },
        progress);
    return results;
  }

  /// Where pictures are wanted, adds one of a subject to a row.
  void draw(ThesisRow& row, const std::string& title, const std::string& caption, const Subject& subject,
            const RenderOptions& options);
  /// The same of a mesh in one shading.
  void draw(ThesisRow& row, const std::string& title, const std::string& caption, const TriangleMesh& mesh,
            Shading shading, double zoom = 1);

  Progress progress;  ///< of the experiment at work
  StageTimes times;
  std::vector<std::string> warnings;

 private:
  const Progress& overall_;
  std::vector<ThesisRow> rows_;
  std::map<std::string, std::pair<std::string, std::optional<TriangleMesh>>> meshes_;
};

/// The experiment of a row for which nothing can stand in. @param needs  what would close it.
ThesisExperiment without_data(const std::string& id, const std::string& claim, const std::string& needs);

}  // namespace batten::experiments
