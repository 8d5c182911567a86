// SPDX-License-Identifier: BSD-3-Clause
#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>

#include <algorithm>

#include "graph/ceres_compat.hpp"
#include "graph/graph_steps.hpp"

namespace voxnav::graph {
namespace {

using PoseMap = Eigen::Map<const Pose4>;

/// Copies a Jacobian to the memory of Ceres, row by row. Ceres passes null for Jacobians that it does not need.
template <int Rows, int Columns>
void store(const Eigen::Matrix<double, Rows, Columns>& value, double* out) {
  for (int i = 0; out && i < Rows; ++i) {
    for (int j = 0; j < Columns; ++j) out[i * Columns + j] = value(i, j);
  }
}

double* block_of(double** jacobians, int block) { return jacobians ? jacobians[block] : nullptr; }

/// 4 residuals; blocks: T_W_a, T_W_b (x y z yaw each, on the yaw manifold). Analytic.
class RelativePoseCost final : public ceres::SizedCostFunction<4, 4, 4> {
 public:
  explicit RelativePoseCost(const RelativePoseFactor& factor) : factor_(factor) {}
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    Matrix4 of_a;
    Matrix4 of_b;
    store(Pose4(factor_.evaluate(PoseMap(blocks[0]), PoseMap(blocks[1]), &of_a, &of_b)), residuals);
    store(of_a, block_of(jacobians, 0));
    store(of_b, block_of(jacobians, 1));
    return true;
  }

 private:
  RelativePoseFactor factor_;
};

/// 4 residuals of a registered pair. Blocks: the poses of its two submaps and of the neighbours between which each of
/// them saw what they share, every submap once. Analytic.
class SeenPairCost final : public ceres::CostFunction {
 public:
  SeenPairCost(const RelativePoseFactor& factor, const SeenFrom& a, const SeenFrom& b) : factor_(factor), sides_{a, b} {
    for (const SeenFrom& side : sides_) {
      for (const int id : {side.id, side.neighbour}) {
        if (std::find(ids_.begin(), ids_.end(), id) == ids_.end()) ids_.push_back(id);
      }
    }
    set_num_residuals(4);
    mutable_parameter_block_sizes()->assign(ids_.size(), 4);
  }
  const std::vector<int>& ids() const { return ids_; }

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    Pose4 poses[2];
    Matrix4 of_own[2];
    Matrix4 of_neighbour[2];
    for (int k = 0; k < 2; ++k) {
      poses[k] = sides_[k].at.evaluate(PoseMap(blocks[block_of_id(sides_[k].id)]),
                                       PoseMap(blocks[block_of_id(sides_[k].neighbour)]), &of_own[k], &of_neighbour[k]);
    }
    Matrix4 of_seen[2];
    store(Pose4(factor_.evaluate(poses[0], poses[1], &of_seen[0], &of_seen[1])), residuals);
    if (!jacobians) return true;
    std::vector<Matrix4> sums(ids_.size(), Matrix4::Zero());
    for (int k = 0; k < 2; ++k) {
      sums[block_of_id(sides_[k].id)] += of_seen[k] * of_own[k];
      sums[block_of_id(sides_[k].neighbour)] += of_seen[k] * of_neighbour[k];
    }
    for (std::size_t i = 0; i < ids_.size(); ++i) store(sums[i], jacobians[i]);
    return true;
  }

 private:
  std::size_t block_of_id(int id) const {
    return static_cast<std::size_t>(std::find(ids_.begin(), ids_.end(), id) - ids_.begin());
  }

  RelativePoseFactor factor_;
  SeenFrom sides_[2];
  std::vector<int> ids_;
};

/// 3 residuals; blocks: T_W_S, T_W_G. Analytic.
class PositionCost final : public ceres::SizedCostFunction<3, 4, 4> {
 public:
  explicit PositionCost(const PositionFactor& factor) : factor_(factor) {}
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    PositionFactor::Jacobian of_pose;
    PositionFactor::Jacobian of_datum;
    store(Eigen::Vector3d(factor_.evaluate(PoseMap(blocks[0]), PoseMap(blocks[1]), &of_pose, &of_datum)), residuals);
    store(of_pose, block_of(jacobians, 0));
    store(of_datum, block_of(jacobians, 1));
    return true;
  }

 private:
  PositionFactor factor_;
};

/// 1 residual; block: T_W_S. Analytic.
class HeightCost final : public ceres::SizedCostFunction<1, 4> {
 public:
  explicit HeightCost(const HeightFactor& factor) : factor_(factor) {}
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    residuals[0] = factor_.evaluate(PoseMap(blocks[0]));
    store(Pose4(0, 0, 1.0 / factor_.sigma_m, 0), block_of(jacobians, 0));
    return true;
  }

 private:
  HeightFactor factor_;
};

ceres::LossFunction* cauchy(double width) { return width > 0.0 ? new ceres::CauchyLoss(width) : nullptr; }

void add_relatives(const GraphState& state, double pair_loss_width, Estimate* x, ceres::Problem* problem) {
  for (const RelativeConstraint& c : state.relatives) {
    if (!state.uses(c)) continue;
    problem->AddResidualBlock(new RelativePoseCost(c.factor), nullptr, x->poses[c.a].data(), x->poses[c.b].data());
  }
  if (!state.uses(ConstraintKind::kRegistration)) return;
  for (const auto& [ids, pair] : state.pairs) {
    if (!pair.is_active) continue;
    auto* cost = new SeenPairCost(pair.factor, seen_from(state, pair.a, pair.overlap.phase_a),
                                  seen_from(state, pair.b, pair.overlap.phase_b));
    std::vector<double*> blocks;
    for (const int id : cost->ids()) blocks.push_back(x->poses[id].data());
    problem->AddResidualBlock(cost, cauchy(pair_loss_width), blocks);
  }
}

void add_absolutes(const GraphState& state, Estimate* x, double* map_frame, ceres::Problem* problem) {
  const double width = state.config.robust_width;
  for (const PositionConstraint& c : state.positions) {
    if (!state.uses(ConstraintKind::kGnss)) break;
    double* datum = c.is_in_map_frame ? map_frame : x->datum.data();
    problem->AddResidualBlock(new PositionCost(c.factor), cauchy(width), x->poses[c.id].data(), datum);
  }
  for (const HeightConstraint& c : state.heights) {
    if (!state.uses(ConstraintKind::kHeight)) break;
    problem->AddResidualBlock(new HeightCost(c.factor), cauchy(width), x->poses[c.id].data());
  }
}

ceres::Solver::Options options_of(const SubmapGraphConfig& config) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  // Eigen suffices for graphs of this size, while the BLAS behind SuiteSparse starts threads that spin as they wait.
  if (ceres::IsSparseLinearAlgebraLibraryTypeAvailable(ceres::EIGEN_SPARSE))
    options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  options.num_threads = 1;  // sums in one order: the same input gives the same bits
  options.max_num_iterations = config.max_solver_iterations;
  options.max_solver_time_in_seconds = 1e9;  // work is bounded by iterations, not by the clock
  options.function_tolerance = 1e-9;
  options.gradient_tolerance = 1e-10;
  options.parameter_tolerance = 1e-10;
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace

SolveSummary solve_factors(const GraphState& state, double pair_loss_width, Estimate* estimate) {
  if (estimate->poses.empty()) return {true, true};
  Estimate x = *estimate;
  Pose4 map_frame = Pose4::Zero();
  ceres::Problem problem;
  for (auto& [id, pose] : x.poses) add_pose_block(&problem, pose.data());
  add_pose_block(&problem, x.datum.data());
  add_pose_block(&problem, map_frame.data());
  problem.SetParameterBlockConstant(x.poses.begin()->second.data());
  problem.SetParameterBlockConstant(map_frame.data());
  if (!state.has_datum) problem.SetParameterBlockConstant(x.datum.data());
  add_relatives(state, pair_loss_width, &x, &problem);
  add_absolutes(state, &x, map_frame.data(), &problem);
  ceres::Solver::Summary summary;
  ceres::Solve(options_of(state.config), &problem, &summary);
  SolveSummary out{summary.termination_type == ceres::CONVERGENCE, summary.IsSolutionUsable()};
  if (out.is_usable) *estimate = std::move(x);
  return out;
}

}  // namespace voxnav::graph
