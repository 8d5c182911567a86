// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "voxnav/geometry/pose.hpp"
#include "voxnav/graph/graph_config.hpp"

namespace voxnav::geometry {
class DistanceField;
}

namespace voxnav::graph {

/// The kind of measurement behind a constraint between submaps, or between a submap and the world.
enum class ConstraintKind { kOdometry, kRegistration, kLoop, kGnss, kHeight };
constexpr auto words_of(ConstraintKind) { return std::array{"odometry", "registration", "loop", "gnss", "height"}; }
constexpr int kNumConstraintKinds = static_cast<int>(words_of(ConstraintKind{}).size());

struct KindReport {
  int num_constraints = 0;   ///< constraints that took part in the solve
  double cost_before = 0.0;  ///< sum of squared whitened residuals, after the robust kernels
  double cost_after = 0.0;
};

struct RejectedLoop {
  int a;
  int b;
  std::string reason;
};

struct OptimizeReport {
  KindReport kinds[kNumConstraintKinds];
  double cost_before = 0.0;
  double cost_after = 0.0;
  bool is_converged = false;
  bool is_input_kept = false;  ///< no better poses were found, or none were needed
  int iterations = 0;          ///< linearisations of the whole graph
  int num_submaps = 0;
  int num_pairs = 0;  ///< overlapping pairs in the graph
  int num_new_pairs = 0;
  int num_pair_evaluations = 0;
  int num_searches = 0;
  int num_recognised = 0;  ///< loop closures found by place recognition in this solve
  double seconds = 0.0;    ///< CPU time of the calling thread; informative only
  std::vector<RejectedLoop> rejected_loops;
};

/// One constraint as it stands after the last solve, for markers and for people.
struct ConstraintView {
  ConstraintKind kind;
  int a;
  int b;         ///< equal to a for constraints of a single submap
  double cost;   ///< squared whitened residual
  bool is_used;  ///< false for kinds that are switched off and loops that were rejected
};

/// Pose graph of submaps with four degrees of freedom each (x, y, z, yaw); roll and pitch are fixed by gravity.
/// The submap with the smallest id stays fixed. The graph itself registers submaps that overlap and adds the
/// constraints between them. The result depends on what was added, not on the order, the clock or threads. Not
/// thread-safe. Source: Reijgwart et al., Voxgraph, RA-L 2020, section IV; see docs/maths/graph.md for what differs.
class SubmapGraph {
 public:
  /// @throws base::ConfigError
  explicit SubmapGraph(const SubmapGraphConfig& config = {});
  ~SubmapGraph();
  SubmapGraph(SubmapGraph&&) noexcept;
  SubmapGraph& operator=(SubmapGraph&&) noexcept;

  /// @param field  surfaces and distances of the submap; without it the submap is not registered to others
  /// @throws std::invalid_argument for an id that exists or a pose that is not gravity-aligned; std::length_error if
  /// the
  ///         graph is full
  void add_submap(int id, const geometry::Pose& T_W_S, std::shared_ptr<const geometry::DistanceField> field = nullptr);

  /// @param information  of (x, y, z, yaw) of the error expressed in frame a; may be semi-definite
  /// @param kind  kOdometry is always used; kLoop is rejected when it disagrees with the rest of the graph
  /// @throws std::invalid_argument for unknown ids, a = b, other kinds, bad pose or information
  void add_relative_pose(int a, int b, const geometry::Pose& T_a_b, const Eigen::Matrix4d& information,
                         ConstraintKind kind);

  /// A measurement that the point p_S of a submap (the antenna, say) is at p_W in the map frame, with its covariance in
  /// m^2. A robust loss limits what an outlier can do.
  /// @throws std::invalid_argument for an unknown id or a covariance that is not positive definite
  void add_position(int id, const geometry::Vec3& p_S, const geometry::Vec3& p_W, const Eigen::Matrix3d& covariance);
  /// A measurement of a position in a frame G (east, north, up, say). The four degrees of freedom of G in the map are
  /// unknown and estimated together with the poses, see gnss_datum().
  void add_gnss_position(int id, const geometry::Vec3& p_S, const geometry::Vec3& p_G,
                         const Eigen::Matrix3d& covariance);
  /// A measurement that the point p_S of a submap is `height_m` high in the map frame. Its loss is robust too.
  void add_height(int id, const geometry::Vec3& p_S, double height_m, double sigma_m);

  void set_kind_enabled(ConstraintKind kind, bool is_enabled);
  bool is_kind_enabled(ConstraintKind kind) const;

  /// Moves the submaps to where the constraints fit best, starting from where they are. Work is bounded by the
  /// configuration; `is_full` lifts the bounds tenfold and registers every pair anew. The poses are never left
  /// worse (by total cost) than they were.
  OptimizeReport optimize(bool is_full = false);

  /// T_W_S of every submap.
  std::map<int, geometry::Pose> poses() const;
  /// The estimated frame of GNSS positions, T_W_G; nothing before the first solve with such positions.
  std::optional<geometry::Pose> gnss_datum() const;
  std::vector<ConstraintView> constraints() const;
  int num_submaps() const;

  /// Poses and relative-pose constraints (odometry and loops) as a g2o text. Registered pairs are left out.
  std::string to_g2o() const;
  /// Constraints between neighbouring ids become odometry, others loops.
  /// @throws std::invalid_argument naming line and fault
  static SubmapGraph from_g2o(const std::string& text, const SubmapGraphConfig& config = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace voxnav::graph
