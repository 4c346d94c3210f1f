#pragma once
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
  bool try_flip(int h);
  bool try_move(int v);

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
