#pragma once
#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "batten/core/progress.hpp"
#include "batten/mesh/halfedge_mesh.hpp"
#include "batten/simplification/face_tree_detail.hpp"

namespace batten::simplification {

/// What an edge collapse would cost and where its vertex would lie.
struct Placement {
  double cost = 0;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
};

struct DecimatorOptions {
  double area_power = 2;        ///< weight of a plane: area to this power
  double regularisation = 1e-3; ///< pull to the middle of the ring, relative to the trace of the quadric
  double border_weight = 1;
  double shape_weight = 0;
  double least_cosine = 0.2;    ///< between the normals of a face before and after
};

/// Greedy edge collapses by memoryless quadrics: the planes are those of the faces as they are now (Lindstrom
/// and Turk 1998), not of the input (Garland and Heckbert 1997), with the volume held by every collapse.
class Decimator {
 public:
  Decimator(HalfedgeMesh& mesh, FaceTree& tree, const DecimatorOptions& options);
  /// Collapses until at most `faces` are left or the least cost exceeds `max_cost`.
  void run(int faces, double max_cost, const Progress& progress);
  /// Called before a collapse of half-edge h to a point.
  std::function<void(int h, const Eigen::Vector3d& point)> on_collapse;

 private:
  /// Symmetric 3 × 3: xx xy xz yy yz zz.
  struct Symmetric {
    double m[6] = {0, 0, 0, 0, 0, 0};
  };
  struct Entry {
    double cost;
    int h;
    std::uint32_t stamp;
    bool operator<(const Entry& other) const { return cost > other.cost || (cost == other.cost && h > other.h); }
  };
  void update_vertex(int v);
  Placement place(int h) const;
  bool is_allowed(int h, const Eigen::Vector3d& p);
  void enqueue(int h);
  int representative(int h) const { return mesh_.is_representative(h) ? h : mesh_.opposite(h); }

  HalfedgeMesh& mesh_;
  FaceTree& tree_;
  DecimatorOptions options_;
  std::vector<Symmetric> quadric_;           ///< per vertex: Σ of its faces' planes (and border edges)
  std::vector<Eigen::Vector3d> sum_normal_;  ///< per vertex: Σ area normals
  std::vector<std::uint32_t> stamp_;         ///< per half-edge: of its entry in the queue
  std::vector<char> stale_;                  ///< per half-edge: cost to be computed again when its turn comes
  std::vector<Entry> heap_;
  std::uint32_t last_stamp_ = 0;
  std::vector<FaceTree::Triangle> star_;
  std::vector<int> replaced_;
};

}  // namespace batten::simplification
