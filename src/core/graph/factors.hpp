// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "graph/pose4.hpp"

/// Residuals of the pose graph and their analytic Jacobians, free of Ceres so that they can be tested alone.
/// Derivation: docs/maths/graph.md. Yaw is a plain number here; its wrap is in the residual and in the manifold.
namespace voxnav::graph {

/// Whitened difference between T_a_b of two poses and a measurement (odometry, loop, or a registered pair):
/// M [R_z(ψ_a)ᵀ (t_b − t_a) − t̂ ; wrap(ψ_b − ψ_a − ψ̂)].
struct RelativePoseFactor {
  Pose4 T_a_b;
  Matrix4 whitening;

  /// Jacobians may be null.
  Pose4 evaluate(const Pose4& T_W_a, const Pose4& T_W_b, Matrix4* jacobian_a, Matrix4* jacobian_b) const;
};

/// The pose of a submap at the time when it saw something, under the assumption that drift grows evenly from the middle
/// of one submap to the middle of the next. The pose of a submap holds for its middle. At `share` (0 to 1/2) of the
/// time from there to the middle of its neighbour, the submap is shifted by this share of the neighbour's correction
/// against odometry: t' = t + share (t_neighbour ± R_z(ψ_earlier) step − t), yaw unchanged.
struct SeenAt {
  double share = 0.0;
  bool is_before = false;                          ///< the neighbour is the submap before this one
  Eigen::Vector3d step = Eigen::Vector3d::Zero();  ///< odometry from the earlier to the later, frame of the earlier

  /// Jacobians may be null.
  Pose4 evaluate(const Pose4& T_W_own, const Pose4& T_W_neighbour, Matrix4* jacobian_own,
                 Matrix4* jacobian_neighbour) const;
};

/// Whitened difference between a point of a submap and where GNSS saw it:
/// M [t + R_z(ψ) p_S − (R_z(ψ_0) p_G + t_0)], datum (t_0, ψ_0) = T_W_G.
struct PositionFactor {
  using Jacobian = Eigen::Matrix<double, 3, 4>;
  Eigen::Vector3d p_S;
  Eigen::Vector3d p_G;
  Eigen::Matrix3d whitening;

  Eigen::Vector3d evaluate(const Pose4& T_W_S, const Pose4& T_W_G, Jacobian* jacobian_pose,
                           Jacobian* jacobian_datum) const;
};

/// Whitened height of a point of a submap: (z + p_S.z − height) / sigma.
struct HeightFactor {
  double p_S_z_m;
  double height_m;
  double sigma_m;

  double evaluate(const Pose4& T_W_S) const { return (T_W_S[2] + p_S_z_m - height_m) / sigma_m; }
};

}  // namespace voxnav::graph
