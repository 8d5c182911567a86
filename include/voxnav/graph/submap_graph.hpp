// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "graph/pose4.hpp"
#include "voxnav/graph/graph_config.hpp"

namespace voxnav::geometry {
class DistanceField;
}

namespace voxnav::graph {

/// What a constraint between submaps, or between a submap and the world, was measured by.
enum class ConstraintKind { kOdometry, kRegistration, kLoop, kGnss, kHeight };
constexpr auto words_of(ConstraintKind) { return std::array{"odometry", "registration", "loop", "gnss", "height"}; }
constexpr int kNumConstraintKinds = static_cast<int>(words_of(ConstraintKind{}).size());

struct KindReport {
  int num_constraints = 0;   ///< that took part
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

/// For people and markers: one constraint as it stands.
struct ConstraintView {
  ConstraintKind kind;
  int a;
  int b;        ///< equal to a where only one submap is held
  double cost;  ///< squared whitened residual
  bool is_used;
};

/// Pose graph of submaps with four degrees of freedom each (x, y, z, yaw); roll and pitch are fixed by gravity.
/// The submap with the smallest id stays where it is. Registration constraints between submaps that overlap are made
/// here. The result depends on what was added, not on the order, the clock or threads. Not thread-safe.
/// Source: Reijgwart et al., Voxgraph, RA-L 2020, section IV; see docs/maths/graph.md for what differs.
class SubmapGraph {
 public:
  /// @throws base::ConfigError
  explicit SubmapGraph(const SubmapGraphConfig& config = {});
  ~SubmapGraph();
  SubmapGraph(SubmapGraph&&) noexcept;
  SubmapGraph& operator=(SubmapGraph&&) noexcept;

  /// @param field  surfaces and distances of the submap; without it the submap is not registered to others
  /// @throws std::invalid_argument for a known id or a pose that is not gravity-aligned; std::length_error when full
  void add_submap(int id, const geometry::Pose& T_W_S, std::shared_ptr<const geometry::DistanceField> field = nullptr);

  /// @param information  of (x, y, z, yaw) of the error expressed in frame a; may be semi-definite
  /// @param kind  kOdometry is trusted, kLoop has to agree with the rest or is rejected
  /// @throws std::invalid_argument for unknown ids, a = b, other kinds, bad pose or information
  void add_relative_pose(int a, int b, const geometry::Pose& T_a_b, const Matrix4& information, ConstraintKind kind);

  /// The point p_S of a submap (antenna lever arm included) is at p_W in the map frame. Robust.
  /// @throws std::invalid_argument for an unknown id or a covariance that is not positive definite
  void add_position(int id, const geometry::Vec3& p_S, const geometry::Vec3& p_W, const Eigen::Matrix3d& covariance);
  /// The same in a frame G whose four degrees of freedom in W are unknown and estimated with the poses.
  void add_gnss_position(int id, const geometry::Vec3& p_S, const geometry::Vec3& p_G,
                         const Eigen::Matrix3d& covariance);
  /// The point at height p_S.z of a submap is at `height_m` in the map frame. Robust.
  void add_height(int id, const geometry::Vec3& p_S, double height_m, double sigma_m);

  void set_kind_enabled(ConstraintKind kind, bool is_enabled);
  bool is_kind_enabled(ConstraintKind kind) const;

  /// Moves the submaps to where the constraints fit best, starting from where they are. Work is bounded by the
  /// configuration; `is_full` lifts the bounds tenfold and registers every pair anew. The poses are never left
  /// worse (by total cost) than they were.
  OptimizeReport optimize(bool is_full = false);

  /// T_W_S of every submap.
  std::map<int, geometry::Pose> poses() const;
  /// T_W_G; nothing before the first solve with GNSS positions.
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
