#pragma once
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "batten/core/arrays.hpp"
#include "batten/core/progress.hpp"
#include "batten/mesh/halfedge_mesh.hpp"
#include "batten/simplification/face_tree_detail.hpp"

namespace batten::simplification {

/// A point of the original surface with the piece of area it stands for.
struct SurfaceSample {
  Eigen::Vector3d point;
  double area;
  Eigen::Vector3f normal;  ///< of the original surface there
  int face;                ///< of the simplified mesh: where the search for the nearest point starts
};

/// `n` or more samples, every one standing for about the same area, and the vertices where the surface bends
/// most, which stand for next to none: they watch over the largest distance. `face` is the face of the
/// original mesh.
std::vector<SurfaceSample> sample_surface(const Points& positions, const Triangles& triangles, int n);

struct FitOptions {
  int rounds = 6;
  /// Pull of every vertex to the place where its triangles are best shaped, against the fit: the weight of
  /// squared distances in edge lengths beside squared errors in units of the mean square error. The rounds
  /// adapt it to the budget.
  double shape_pull = 10;
  /// Share of the mean square error that a flip may cost for a gain of 60° of smallest angles.
  double flip_shape = 10;
  /// The root mean square error to end with, relative to that at the start, where triangles are well shaped
  /// and where they are poor: what the fit gains goes into shape.
  double budget_good = 0.93, budget_poor = 1.03;
};

/// Moves the vertices and turns the edges of a simplified mesh so that it fits samples of the original
/// surface in the least-squares sense, with well-shaped triangles. Nothing is folded or made to intersect;
/// border vertices and marked edges stay.
class SurfaceFit {
 public:
  SurfaceFit(HalfedgeMesh& mesh, FaceTree& tree, std::vector<SurfaceSample> samples,
             const FitOptions& options);
  /// Starts the search for sample s at the best of the faces around some vertices. Several samples may be
  /// started at once.
  void start_at(int s, const int* vertices, int n);
  void run(const Progress& progress);
  /// Root mean square and largest distance of the samples, after the last locate().
  double rms() const { return rms_; }
  double largest_distance() const;

  void locate(const Progress& progress = {});
  int flip_edges(const Progress& progress = {});
  int move_vertices(const Progress& progress = {});

 private:
  struct Located {
    double weights[3];
    Eigen::Vector3d direction;  ///< unit, from the surface to the sample; the face normal where it lies on it
    double squared;
  };
  double squared_distance(const Eigen::Vector3d& p, int f, double* weights) const;
  void locate_one(int s);
  double mean_smallest_angle() const;

  /// Whether turning the edge of h folds nothing and gains shape or fit. Looks at its two faces alone.
  bool gains_by_flip(int h) const;
  /// Turns the edge where the turned faces meet no others. @pre gains_by_flip(h)
  bool flip_if_free(int h);

  /// The linearised least-squares problem of one vertex, `matrix` · step = `right`: squared distances of the
  /// samples around it, and `weight` times the squared tangential distance from where its triangles are best
  /// shaped.
  struct Pull {
    bool held = false;  ///< on a marked edge, or without a normal
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero(), tangential = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero(), target = Eigen::Vector3d::Zero();
    double weight = 0, least_height = 1;
    double shortest = std::numeric_limits<double>::infinity();  ///< square of the shortest edge
  };
  Pull pull_at(int v) const;
  /// What a vertex costs where it is put: the energy whose linearisation Pull is, the squared distances of
  /// the nearest and furthest sample, and how high above the nearest one's tangent plane it lies.
  struct Fit {
    double sum, nearest, furthest, height;
  };
  Fit fit_at(int v, const Eigen::Vector3d& x, const Pull& pull) const;
  bool keeps_shape(int v, const Eigen::Vector3d& q, double least_height) const;

  static constexpr int kAttempts = 3;  ///< at a move, each 0.3 times as long as the one before
  struct Move {
    int attempt = kAttempts;  ///< that led there; kAttempts: stay
    Eigen::Vector3d to = Eigen::Vector3d::Zero();
  };
  /// Where a vertex should go, apart from what other faces it would meet. Looks at the faces around it alone.
  Move plan_move(int v, int first_attempt) const;
  /// Makes the move, or the next shorter one that meets no other faces.
  bool move_if_free(int v, Move move);
  /// Inner vertices in sets of which no two share a face.
  std::vector<std::vector<int>> independent_vertices() const;

  HalfedgeMesh& mesh_;
  FaceTree& tree_;
  std::vector<SurfaceSample> samples_;
  std::vector<Located> located_;
  std::vector<int> first_, next_;  ///< samples per face as linked lists
  FitOptions options_;
  double rms_ = 0, area_ = 0, budget_ = 0, largest_ = 0, spacing_ = 0, shape_pull_ = 0;
  std::vector<FaceTree::Triangle> star_;
  std::vector<int> replaced_;
};

}  // namespace batten::simplification
