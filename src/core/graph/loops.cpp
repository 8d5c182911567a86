// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cstdio>
#include <limits>

#include "graph/graph_steps.hpp"

namespace voxnav::graph {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Matrix8 = Eigen::Matrix<double, 8, 8>;

/// Covariances of poses: parts of the inverse of the graph's Gauss-Newton matrix at an estimate.
class Marginals {
 public:
  Marginals(const GraphState& state, const Estimate& estimate) {
    for (const auto& [id, pose] : estimate.poses) columns_.emplace(id, 4 * static_cast<int>(columns_.size()));
    add_anchors(state, estimate);
    for (const RelativeConstraint& c : state.relatives) {
      if (state.uses(c)) add(c.a, c.b, c.factor, estimate);
    }
    for (const auto& [ids, pair] : state.pairs) {
      if (pair.is_active && state.uses(ConstraintKind::kRegistration)) add(pair.a, pair.b, pair.factor, estimate);
    }
    const int size = 4 * static_cast<int>(columns_.size());
    Sparse hessian(size, size);
    hessian.setFromTriplets(entries_.begin(), entries_.end());
    solver_.compute(hessian);
  }

  bool is_valid() const { return solver_.info() == Eigen::Success; }

  /// Joint covariance of two poses: x, y, z, yaw of a, then of b.
  Matrix8 joint(int a, int b) const {
    const int column[2] = {columns_.at(a), columns_.at(b)};
    Eigen::MatrixXd units = Eigen::MatrixXd::Zero(solver_.rows(), 8);
    for (int k = 0; k < 8; ++k) units(column[k / 4] + k % 4, k) = 1.0;
    const Eigen::MatrixXd solved = solver_.solve(units);
    Matrix8 out;
    for (int k = 0; k < 8; ++k) out.row(k) = solved.row(column[k / 4] + k % 4);
    return out;
  }

 private:
  void add_anchors(const GraphState& state, const Estimate& estimate) {
    constexpr double kFixed = 1e12;
    constexpr double kLoose = 1e-6;  // sigma of a kilometre, so that a submap without constraints is not singular
    for (const auto& [id, column] : columns_) {
      for (int k = 0; k < 4; ++k) entries_.emplace_back(column + k, column + k, column == 0 ? kFixed : kLoose);
    }
    if (!state.uses(ConstraintKind::kGnss)) return;
    for (const PositionConstraint& c : state.positions) {
      PositionFactor::Jacobian J;
      c.factor.evaluate(estimate.poses.at(c.id), estimate.datum, &J, nullptr);
      add_block(columns_.at(c.id), columns_.at(c.id), J.transpose() * J);
    }
  }
  void add(int a, int b, const RelativePoseFactor& factor, const Estimate& estimate) {
    Matrix4 J_a;
    Matrix4 J_b;
    factor.evaluate(estimate.poses.at(a), estimate.poses.at(b), &J_a, &J_b);
    add_block(columns_.at(a), columns_.at(a), J_a.transpose() * J_a);
    add_block(columns_.at(b), columns_.at(b), J_b.transpose() * J_b);
    add_block(columns_.at(a), columns_.at(b), J_a.transpose() * J_b);
    add_block(columns_.at(b), columns_.at(a), J_b.transpose() * J_a);
  }
  void add_block(int row, int column, const Matrix4& block) {
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) entries_.emplace_back(row + i, column + j, block(i, j));
    }
  }

  std::map<int, int> columns_;
  std::vector<Eigen::Triplet<double>> entries_;
  Eigen::SimplicialLDLT<Sparse> solver_;
};

double residual_chi2(const RelativeConstraint& loop, const Estimate& estimate) {
  return loop.factor.evaluate(estimate.poses.at(loop.a), estimate.poses.at(loop.b), nullptr, nullptr).squaredNorm();
}

/// Squared Mahalanobis distance between a loop and the graph without it: in whitened units of the loop,
/// eᵀ (1 + J Σ Jᵀ)⁻¹ e.
double innovation_chi2(const RelativeConstraint& loop, const Estimate& estimate, const Marginals& marginals) {
  Matrix4 J_a;
  Matrix4 J_b;
  const Pose4 error = loop.factor.evaluate(estimate.poses.at(loop.a), estimate.poses.at(loop.b), &J_a, &J_b);
  Eigen::Matrix<double, 4, 8> J;
  J << J_a, J_b;
  const Matrix4 spread = J * marginals.joint(loop.a, loop.b) * J.transpose() + Matrix4::Identity();
  return error.dot(spread.ldlt().solve(error));
}

std::string sentence(const char* format, double chi2, double gate) {
  char text[160];
  std::snprintf(text, sizeof(text), format, chi2, gate);
  return text;
}

/// Accepts the loops that agree with the graph as it is and rejects the others. @return how many were accepted
int accept_agreeing(GraphState* state, const Estimate& estimate) {
  const double gate = state->config.loop_gate_chi2;
  std::optional<Marginals> marginals;
  std::vector<RelativeConstraint*> agreeing;
  for (RelativeConstraint& loop : state->relatives) {
    if (loop.kind != ConstraintKind::kLoop || loop.state == LoopState::kAccepted) continue;
    // Two places confirmed this loop. It is not tested against the graph, which does not know how far it has drifted.
    if (loop.is_recognised) {
      agreeing.push_back(&loop);
      continue;
    }
    // The covariance of the graph only lowers the distance, so a small residual passes without the marginals.
    double chi2 = residual_chi2(loop, estimate);
    if (chi2 > gate) {
      if (!marginals) marginals.emplace(*state, estimate);
      if (marginals->is_valid()) chi2 = innovation_chi2(loop, estimate, *marginals);
    }
    if (chi2 <= gate) {
      agreeing.push_back(&loop);
    } else {
      loop.state = LoopState::kRejected;
      loop.reason = sentence("disagrees with the graph: squared Mahalanobis distance %.1f, allowed %.1f", chi2, gate);
    }
  }
  for (RelativeConstraint* loop : agreeing) loop->state = LoopState::kAccepted;
  return static_cast<int>(agreeing.size());
}

/// Rejects the accepted loop that contradicts the other constraints most. @return false if all agree
bool reject_worst(GraphState* state, const Estimate& estimate) {
  RelativeConstraint* worst = nullptr;
  double worst_chi2 = state->config.loop_gate_chi2;
  for (RelativeConstraint& loop : state->relatives) {
    if (loop.kind != ConstraintKind::kLoop || loop.state != LoopState::kAccepted) continue;
    const double chi2 = residual_chi2(loop, estimate);
    if (chi2 > worst_chi2) {
      worst_chi2 = chi2;
      worst = &loop;
    }
  }
  if (!worst) return false;
  worst->state = LoopState::kRejected;
  worst->reason = sentence("contradicted after the solve: squared residual %.1f sigma^2, allowed %.1f", worst_chi2,
                           state->config.loop_gate_chi2);
  return true;
}

}  // namespace

void judge_loops(GraphState* state, bool is_full, Estimate* estimate) {
  constexpr int kMaxRounds = 5;
  constexpr int kMaxRejections = 20;
  std::vector<RelativeConstraint*> loops;
  bool is_news = is_full;
  for (RelativeConstraint& c : state->relatives) {
    if (c.kind != ConstraintKind::kLoop) continue;
    loops.push_back(&c);
    is_news = is_news || c.state == LoopState::kUntested;
  }
  if (loops.empty() || !state->uses(ConstraintKind::kLoop)) return;
  const double pair_width = state->config.robust_width;
  if (!state->config.is_loop_rejection_enabled) {
    for (RelativeConstraint* loop : loops) loop->state = LoopState::kAccepted;
    solve_factors(*state, pair_width, estimate);
    return;
  }
  if (is_news) {
    // All loops are tested again from the graph without them, so that one wrongly accepted loop does not lock out later
    // ones.
    for (RelativeConstraint* loop : loops) loop->state = LoopState::kUntested;
    solve_factors(*state, pair_width, estimate);
    // There are several rounds, because accepted loops correct the graph, after which other true loops may fit.
    for (int round = 0; round < kMaxRounds && accept_agreeing(state, *estimate) > 0; ++round) {
      solve_factors(*state, pair_width, estimate);
    }
  }
  for (int k = 0; k < kMaxRejections && reject_worst(state, *estimate); ++k) {
    solve_factors(*state, pair_width, estimate);
  }
}

}  // namespace voxnav::graph
