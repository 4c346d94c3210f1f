#pragma once
#include <vector>

#include <Eigen/Core>

#include "batten/core/progress.hpp"
#include "batten/core/units.hpp"
#include "batten/scan/bordered_chain_detail.hpp"
#include "batten/scan/field_detail.hpp"
#include "batten/scan/motion_detail.hpp"
#include "batten/scan/orientation.hpp"

namespace batten {

/// Calibrated readings, row by row.
struct InertialRecording {
  Eigen::VectorXd time;      ///< n, seconds, not decreasing
  SensorStream rate, force;  ///< gyroscope, accelerometer
  Points field;              ///< n × 3, NaN where there is none
  double longest_gap = 0;    ///< between two readings that belong together, seconds
  /// Appends the motion from row i to row i + 1.
  void append(Eigen::Index i, const InertialErrors& errors, Motion& motion) const;
};

/// The problem behind estimate_orientation(): knots along a recording and what is known of them.
class OrientationSmoother {
 public:
  struct Knot {
    Eigen::Index row = 0;
    Eigen::Matrix3d X = Eigen::Matrix3d::Identity();  ///< device → world
    Eigen::Vector3d v = Eigen::Vector3d::Zero(), p = Eigen::Vector3d::Zero();
    /// Mean reading of the magnetometer from here to the next knot, turned into the axes here, and the mean
    /// of the turns: an offset of the sensor shows in it as `turn` times the offset.
    Eigen::Vector3d reading = Eigen::Vector3d::Zero();
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    Eigen::Vector3d field = Eigen::Vector3d::Zero();  ///< without the offset, in the world
    bool has_field = false;
    double time = 0;     ///< that the knot stands for, seconds
    double heading = 0;  ///< of the field, radians; 0 is right
    double quality = 0;  ///< weight of the field for its strength and dip, [0, 1]
    double weight = 0;   ///< for its heading as well
  };

  /// @param start orientations per row, from a filter. @pre the recording outlives this.
  OrientationSmoother(const InertialRecording& recording, const OrientationOptions& options,
                      const std::vector<Eigen::Matrix3d>& start);

  /// Gauss–Newton to the end, with the deviation of the headings where it is not given.
  /// @throws SolverFailure, Cancelled.
  void solve(const Progress& progress);

  const std::vector<Knot>& knots() const { return knots_; }
  const std::vector<Motion>& motions() const { return motions_; }
  const InertialErrors& errors() const { return errors_; }
  const std::vector<Eigen::Matrix3d>& covariances() const { return covariances_; }  ///< turns, per knot
  Eigen::Vector3d bias_deviation() const;
  const FieldFigures& reference() const { return reference_; }
  const Eigen::Vector3d& field_offset() const { return offset_; }
  double heading_deviation() const { return heading_deviation_; }
  bool has_field() const { return has_field_; }
  int iterations() const { return iterations_; }
  bool converged() const { return converged_; }
  /// Residual of the turn from knot k to the next, and of the velocity, in deviations.
  Eigen::Vector3d turn_residual(int k) const;
  Eigen::Vector3d velocity_residual(int k) const;
  double turn_deviation(int k) const;
  double velocity_deviation(int k) const;
  /// log of exp(r) = ΔRᵀ X_kᵀ X_{k+1}: what the gyroscope misses.
  Eigen::Vector3d turn_misfit(int k) const;
  double gravity() const { return kUsualGravity * (1 + gravity_excess_); }

 private:
  using Chain = BorderedChain<9>;  ///< turn, velocity, place of a knot

  void preintegrate();
  void update_motions();
  void weigh_fields(double gate);
  void fit_offset(bool decide);
  void fit_reference();
  void update_deviation();
  void step(const Progress& progress);
  void assemble();
  void assemble_step(int k);
  void assemble_bounds(int k);
  void apply();

  const InertialRecording& recording_;
  OrientationOptions options_;
  std::vector<Knot> knots_;
  std::vector<Motion> summed_, motions_;  ///< as summed up last, and for the present errors
  InertialErrors summed_with_, errors_;
  double gravity_excess_ = 0;
  FieldFigures reference_;
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();
  bool has_field_ = false, has_offset_ = false;
  double heading_deviation_;  ///< found or given
  double deviation_ = 0;      ///< in use: larger at first
  double turned_ = 0;         ///< the largest turn of the last step, radians
  Chain system_;
  std::vector<Eigen::Matrix3d> covariances_;
  int iterations_ = 0;
  bool converged_ = false;
};

}  // namespace batten
