#include "meshlab.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <unistd.h>

#include "batten/core/error.hpp"
#include "batten/core/statistics.hpp"
#include "batten/core/text.hpp"
#include "batten/io/mesh_io.hpp"

namespace batten::meshlab {

namespace {

namespace fs = std::filesystem;
using Kind = Filter::Kind;

bool is_on_path(const std::string& program) {
  return std::system(concat("command -v ", program, " >/dev/null 2>&1").c_str()) == 0;
}

/// A folder of this process, removed at its end.
class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / concat("batten_meshlab_", getpid())) {
    fs::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string file(const std::string& name) const { return (path_ / name).string(); }

 private:
  fs::path path_;
};

void write_script(const std::string& path, const Filter& filter) {
  std::ofstream out(path);
  out << "<!DOCTYPE FilterScript>\n<FilterScript>\n <filter name=\"" << filter.name << "\">\n";
  for (const Filter::Parameter& parameter : filter.parameters) {
    constexpr std::array<const char*, 4> kTypes = {"RichBool", "RichInt", "RichFloat", "RichAbsPerc"};
    out << "  <Param type=\"" << kTypes[static_cast<std::size_t>(parameter.kind)] << "\" name=\""
        << parameter.name << "\" value=\"" << parameter.value << '"';
    // The bounds only scale a slider.
    if (parameter.kind == Kind::Length) out << " min=\"0\" max=\"1\"";
    out << "/>\n";
  }
  out << " </filter>\n</FilterScript>\n";
}

std::string last_line(const std::string& path) {
  std::ifstream in(path);
  std::string last;
  for (std::string line; std::getline(in, line);)
    if (!line.empty()) last = line;
  return last;
}

struct Times {
  double wall = 0, cpu = 0;
};

/// Runs the server on in.ply and writes out.ply, in `folder`. The times leave out the start of the display.
Times run(const Folder& folder, const Filter& filter) {
  write_script(folder.file("script.mlx"), filter);
  const std::string out = folder.file("out.ply"), times = folder.file("times");
  fs::remove(out);
  std::ofstream(folder.file("run.sh"))
      << "TIMEFORMAT='%R %U %S'\n{ time meshlabserver -i " << folder.file("in.ply") << " -o " << out << " -s "
      << folder.file("script.mlx") << " >" << folder.file("log") << " 2>&1; } 2>" << times << '\n';
  const bool has_display = std::getenv("DISPLAY") != nullptr;
  const int status =
      std::system(concat(has_display ? "" : "xvfb-run -a ", "bash ", folder.file("run.sh")).c_str());
  if (status != 0 || !fs::exists(out))
    throw InvalidInput(
        concat("MeshLab failed in '", filter.name, "'; its last words: ", last_line(folder.file("log"))));
  double wall = 0, user = 0, system = 0;
  std::ifstream(times) >> wall >> user >> system;
  return {wall, user + system};
}

}  // namespace

Filter quadric_edge_collapse(Eigen::Index n_faces) {
  return {"Simplification: Quadric Edge Collapse Decimation",
          {{Kind::Int, "TargetFaceNum", concat(n_faces)},
           {Kind::Float, "TargetPerc", "0"},
           {Kind::Float, "QualityThr", "0.3"},
           {Kind::Bool, "PreserveBoundary", "false"},
           {Kind::Float, "BoundaryWeight", "1"},
           {Kind::Bool, "PreserveNormal", "false"},
           {Kind::Bool, "PreserveTopology", "false"},
           {Kind::Bool, "OptimalPlacement", "true"},
           {Kind::Bool, "PlanarQuadric", "false"},
           {Kind::Float, "PlanarWeight", "0.001"},
           {Kind::Bool, "QualityWeight", "false"},
           {Kind::Bool, "AutoClean", "true"},
           {Kind::Bool, "Selected", "false"}}};
}

Filter isotropic_remeshing(double length, double diameter) {
  Filter filter{"Remeshing: Isotropic Explicit Remeshing",
                {{Kind::Int, "Iterations", "10"},
                 {Kind::Bool, "Adaptive", "false"},
                 {Kind::Bool, "SelectedOnly", "false"},
                 {Kind::Length, "TargetLen", exact_decimal(length)},
                 {Kind::Float, "FeatureDeg", "30"},
                 {Kind::Bool, "CheckSurfDist", "true"},
                 {Kind::Length, "MaxSurfDist", exact_decimal(diameter / 100)}}};
  for (const char* step : {"SplitFlag", "CollapseFlag", "SwapFlag", "SmoothFlag", "ReprojectFlag"})
    filter.parameters.push_back({Kind::Bool, step, "true"});
  return filter;
}

Filter two_step_smoothing() {
  return {"TwoStep Smooth",
          {{Kind::Int, "stepSmoothNum", "3"},
           {Kind::Float, "normalThr", "60"},
           {Kind::Int, "stepNormalNum", "20"},
           {Kind::Int, "stepFitNum", "20"},
           {Kind::Bool, "Selected", "false"}}};
}

Filter taubin_smoothing(int steps) {
  return {"Taubin Smooth",
          {{Kind::Float, "lambda", "0.5"},
           {Kind::Float, "mu", "-0.53"},
           {Kind::Int, "stepSmoothNum", concat(steps)},
           {Kind::Bool, "Selected", "false"}}};
}

bool is_available() {
  static const bool available =
      is_on_path("meshlabserver") && (std::getenv("DISPLAY") != nullptr || is_on_path("xvfb-run"));
  return available;
}

Result apply(const Filter& filter, const TriangleMesh& mesh) {
  const Folder folder;
  TriangleMesh bare;
  bare.positions = mesh.positions;
  bare.triangles = mesh.triangles;
  write_mesh(folder.file("in.ply"), bare);
  std::array<double, 3> wall{}, cpu{};
  for (std::size_t k = 0; k < wall.size(); ++k) {
    const Times idle = run(folder, taubin_smoothing(1));
    wall[k] = idle.wall;
    cpu[k] = idle.cpu;
  }
  const Times times = run(folder, filter);
  Result result;
  result.seconds = std::max(0.0, times.wall - median(wall));
  result.cpu_seconds = std::max(0.0, times.cpu - median(cpu));
  result.mesh = read_mesh(folder.file("out.ply"));
  return result;
}

}  // namespace batten::meshlab
