#pragma once
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "batten/core/progress.hpp"

namespace batten {

struct AdjacencyGraph;

/// L S Lᵀ, S = ±1, of a sparse symmetric matrix of dense B × B blocks, without pivoting: positive definite,
/// or quasi-definite [vanderbei1995] (negative definite in the unknowns that are multipliers), which has a
/// factor in every order. The pattern is analysed once. Independent subtrees of the elimination tree are
/// worked on by all threads; no sum depends on their number.
template <int B>
class BlockLdlt {
 public:
  using Block = Eigen::Matrix<double, B, B>;
  /// Where the block of two unknowns lies: the one eliminated later has the rows.
  struct Slot {
    int place = -1;
    bool transposed = false;  ///< the block asked for is the transpose of the one stored
  };

  BlockLdlt() = default;
  /// @param n blocks of unknowns. @param joined pairs whose block is not zero; the diagonal need not be
  /// named.
  /// @param multiplier per unknown, not 0: its part of the matrix is negative definite.
  /// @throws Cancelled.
  BlockLdlt(int n, const std::vector<std::pair<int, int>>& joined, std::vector<char> multiplier = {},
            const Progress& progress = {});

  int size() const { return n_; }
  /// Multiplications and additions of blocks in one factorisation, about.
  double work() const { return work_; }
  /// @pre the pair was named, or a = b.
  Slot slot(int a, int b) const;

  /// All blocks to 0, to be added up anew: a factor replaces the matrix.
  void clear();
  /// Adds the block with the rows of a and the columns of b, slot(a, b). On the diagonal the whole symmetric
  /// block is wanted.
  void add(Slot slot, const Block& block) {
    if (slot.transposed)
      values_[slot.place] += block.transpose();
    else
      values_[slot.place] += block;
  }
  /// @return false where a pivot has not the sign that it must have, or is not finite. @throws Cancelled.
  bool factorize(const Progress& progress = {});
  /// Of the matrix, log of its absolute value. @pre factorize() has succeeded, as for all below.
  double log_determinant() const { return log_determinant_; }
  Eigen::VectorXd solve(const Eigen::VectorXd& right) const;
  /// L z with the rows in the order of the unknowns: of independent z of deviation 1 it has the matrix as its
  /// covariance. @pre no unknown is a multiplier.
  Eigen::VectorXd root_times(const Eigen::VectorXd& z) const;

  /// The blocks of the inverse at the non-zero blocks of the factor, as if [takahashi1973] were printed with
  /// blocks: about twice the work of a factorisation.
  void invert(const Progress& progress = {});
  /// The same for those only that the diagonal blocks of some unknowns need.
  void invert(const std::vector<int>& unknowns, const Progress& progress = {});
  Block inverse(Slot slot) const {
    return slot.transposed ? Block(inverse_[slot.place].transpose()) : inverse_[slot.place];
  }

 private:
  using Vector = Eigen::Matrix<double, B, 1>;
  struct RowEntry {
    int column, place;
  };

  void order(const AdjacencyGraph& graph, const Progress& progress);
  void analyse(const AdjacencyGraph& graph, const Progress& progress);
  void plan();
  bool eliminate(int column, int* target);
  void invert_column(int column);
  template <typename Body>
  void upwards(const Body& body, const Progress& progress) const;
  template <typename Body>
  void downwards(const Body& body, const Progress& progress) const;

  int n_ = 0;
  double work_ = 0;
  std::vector<int> position_;   ///< per unknown: when it is eliminated
  std::vector<int> unknown_;    ///< the inverse
  std::vector<char> negative_;  ///< per position
  std::vector<int> parent_;
  std::vector<int> first_;      ///< per column the place of its diagonal block; n + 1
  std::vector<int> rows_;       ///< per place, increasing within a column
  std::vector<int> row_first_;  ///< per row its blocks left of the diagonal, n + 1
  std::vector<RowEntry> row_;
  struct Range {
    int begin, end;
  };
  std::vector<Range> subtrees_;  ///< columns that depend on no others but their own
  std::vector<int> top_;         ///< the other columns, increasing
  std::vector<Block> values_, inverse_;
  std::vector<double> log_pivot_;
  std::vector<char> wanted_;  ///< columns that invert() is to fill
  double log_determinant_ = 0;
};

extern template class BlockLdlt<1>;
extern template class BlockLdlt<3>;

}  // namespace batten
