// SPDX-License-Identifier: BSD-3-Clause
// The model of a pair as a factor of the graph, and the descent of one pair by itself.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "graph/pair_registration.hpp"

namespace voxnav::graph {
namespace {

/// Basis in which the Hessian of a pair is well scaled. Its columns are unit moves along x, y and z, and a turn about
/// the centre of the points that moves a point at their rms radius by a metre.
Matrix4 centered_basis(const PairModel& model) {
  // Turning by dψ about the centre adds dt = −dψ (k × c') to the translation, c' = centre as seen from A's origin.
  const Eigen::Vector2d lever = model.center_A - model.T_A_B.head<2>();
  Matrix4 basis = Matrix4::Identity();
  basis.col(3) << lever.y() / model.radius_m, -lever.x() / model.radius_m, 0.0, 1.0 / model.radius_m;
  return basis;
}

}  // namespace

RelativePoseFactor to_factor(const PairModel& model, double information, double noise_floor, double max_step_m) {
  const Matrix4 basis = centered_basis(model);
  const Eigen::SelfAdjointEigenSolver<Matrix4> eigen(basis.transpose() * model.hessian * basis);
  const Pose4 slope = eigen.eigenvectors().transpose() * basis.transpose() * model.gradient;
  Pose4 step = Pose4::Zero();
  Pose4 strength = Pose4::Zero();
  for (int k = 0; k < 4; ++k) {
    const double kept = eigen.eigenvalues()[k] - noise_floor;
    if (kept <= 0.0) continue;
    strength[k] = std::sqrt(information * kept);
    step[k] = std::clamp(-slope[k] / eigen.eigenvalues()[k], -max_step_m, max_step_m);
  }
  RelativePoseFactor out;
  out.T_a_b = model.T_A_B + basis * eigen.eigenvectors() * step;
  out.T_a_b[3] = geometry::wrap_angle(out.T_a_b[3]);
  out.whitening = strength.asDiagonal() * eigen.eigenvectors().transpose() * basis.inverse();
  return out;
}

PairModel refine_pair(const SurfaceSample& a, const SurfaceSample& b, const PairOverlap& overlap, const Pose4& T_A_B,
                      const std::vector<double>& kernels_m, double noise_floor) {
  constexpr int kMaxSteps = 12;
  PairModel model;
  model.T_A_B = T_A_B;
  for (const double kernel_m : kernels_m) {
    model = evaluate_pair(a, b, overlap, model.T_A_B, kernel_m);
    for (int step = 0; step < kMaxSteps; ++step) {
      const Pose4 target = to_factor(model, 1.0, noise_floor, kernel_m).T_a_b;
      const PairModel next = evaluate_pair(a, b, overlap, target, kernel_m);
      if (!(next.cost_m2 < model.cost_m2)) break;
      const double moved = (target - model.T_A_B).head<3>().norm();
      model = next;
      if (moved < 0.01 * kernel_m) break;
    }
  }
  return model;
}

}  // namespace voxnav::graph
