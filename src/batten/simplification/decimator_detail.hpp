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
  /// Pull of the new vertex to the middle of its edge, relative to the trace of the quadric: what decides
  /// where the planes leave it free.
  double regularisation = 1e-6;
  double least_cosine = 0.2;  ///< between the normals of a face before and after
  /// Collapses keep marked edges: their vertices move along them only, ends and crossings not at all.
  bool keep_marked = false;
  /// No collapse moves or removes a vertex on the border.
  bool hold_border = false;
  /// Order by (2.100) instead of by the error alone: positions whose distances are the lengths of edges,
  /// updated with every collapse, or null.
  std::vector<Eigen::Vector3d>* flowed = nullptr;
  double alpha = 1, beta = 1;
};

/// Smallest cost first, ties by the smaller half-edge. Costs are sorted into buckets by their leading bits,
/// and only the bucket in use is kept as a heap, which then stays in the cache.
class CostQueue {
 public:
  struct Entry {
    double cost;
    int h;
    std::uint32_t stamp;
    bool operator<(const Entry& other) const {
      return cost > other.cost || (cost == other.cost && h > other.h);
    }
  };
  /// @pre entry.cost >= 0
  void push(const Entry& entry);
  /// Takes out the least; false when there is none.
  bool pop(Entry& entry);

 private:
  static std::size_t bucket(double cost);
  std::vector<Entry> heap_;
  std::vector<std::vector<Entry>> buckets_ = std::vector<std::vector<Entry>>(4096);
  std::size_t current_ = 0;  ///< buckets up to this one are in the heap
};

/// Greedy edge collapses by memoryless quadrics: the planes are those of the faces as they are now
/// [lindstrom1998], not of the input [garland1997], with the volume held by every collapse.
class Decimator {
 public:
  Decimator(HalfedgeMesh& mesh, FaceTree& tree, const DecimatorOptions& options,
            const Progress& progress = {});
  /// Collapses until at most `faces` are left or the least cost exceeds `max_cost`.
  void run(int faces, double max_cost, const Progress& progress);
  /// Called before a collapse of half-edge h to a point.
  std::function<void(int h, const Eigen::Vector3d& point)> on_collapse;

 private:
  /// Symmetric 3 × 3: xx xy xz yy yz zz.
  struct Symmetric {
    double m[6] = {0, 0, 0, 0, 0, 0};
  };
  void update_vertex(int v);
  Placement place(int h) const;
  double order_of(int h, double cost) const;
  enum class Hold { Free, From, To, Never };
  /// Where marked edges and the border allow the vertex of a collapse to lie.
  Hold held(int h) const;
  bool is_allowed(int h, const Eigen::Vector3d& p);
  void enqueue(int h) { enqueue(h, order_of(h, place(h).cost)); }
  void enqueue(int h, double order);
  /// Costs of all edges, and the largest that (2.100) divides by.
  void enqueue_all(const Progress& progress);
  int representative(int h) const { return mesh_.is_representative(h) ? h : mesh_.opposite(h); }

  HalfedgeMesh& mesh_;
  FaceTree& tree_;
  DecimatorOptions options_;
  std::vector<Symmetric> quadric_;           ///< per vertex: Σ of its faces' planes (and border edges)
  std::vector<Eigen::Vector3d> sum_normal_;  ///< per vertex: Σ area normals
  std::vector<std::uint32_t> stamp_;         ///< per half-edge: of its entry in the queue
  std::vector<char> stale_;                  ///< per half-edge: cost to be computed again when its turn comes
  CostQueue queue_;
  double largest_cost_ = 0, largest_length_ = 0;  ///< of (2.100)
  std::uint32_t last_stamp_ = 0;
  std::vector<FaceTree::Triangle> star_;
  std::vector<int> replaced_;
};

}  // namespace batten::simplification
