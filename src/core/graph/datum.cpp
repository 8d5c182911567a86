// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "graph/graph_steps.hpp"

namespace voxnav::graph {
namespace {

struct Match {
  geometry::Vec3 p_W;
  geometry::Vec3 p_G;
  double weight = 1.0;
};

std::vector<Match> matches_of(const GraphState& state) {
  std::vector<Match> out;
  for (const PositionConstraint& c : state.positions) {
    if (c.is_in_map_frame) continue;
    out.push_back({to_pose(state.estimate.poses.at(c.id)) * c.factor.p_S, c.factor.p_G});
  }
  return out;
}

struct Alignment {
  Pose4 T_W_G;
  double spread_m;
};

/// Computes the weighted least-squares heading and translation between two point sets.
/// Source: Umeyama, Least-squares estimation of transformation parameters between two point patterns, PAMI 1991,
/// restricted to rotations about z.
Alignment align(const std::vector<Match>& matches) {
  constexpr double kMinSpreadM = 0.5;  // below it the heading is noise
  geometry::Vec3 mean_W = geometry::Vec3::Zero();
  geometry::Vec3 mean_G = geometry::Vec3::Zero();
  double total = 0.0;
  for (const Match& m : matches) {
    mean_W += m.weight * m.p_W;
    mean_G += m.weight * m.p_G;
    total += m.weight;
  }
  mean_W /= total;
  mean_G /= total;
  double sine = 0.0;
  double cosine = 0.0;
  double spread2 = 0.0;
  for (const Match& m : matches) {
    const geometry::Vec3 w = m.p_W - mean_W;
    const geometry::Vec3 g = m.p_G - mean_G;
    sine += m.weight * (g.x() * w.y() - g.y() * w.x());
    cosine += m.weight * (g.x() * w.x() + g.y() * w.y());
    spread2 += m.weight * g.head<2>().squaredNorm();
  }
  Alignment out;
  out.spread_m = std::sqrt(spread2 / total);
  const double yaw = out.spread_m > kMinSpreadM ? std::atan2(sine, cosine) : 0.0;
  out.T_W_G << mean_W - to_pose(Pose4(0, 0, 0, yaw)) * mean_G, yaw;
  return out;
}

/// Lowers the weights of fixes that lie far from the alignment, compared with the median fix, for the next iteration.
void reweigh(const Pose4& T_W_G, std::vector<Match>* matches) {
  std::vector<double> errors;
  for (const Match& m : *matches) errors.push_back((m.p_W - to_pose(T_W_G) * m.p_G).norm());
  std::vector<double> sorted = errors;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
  const double scale_m = std::max(0.01, sorted[sorted.size() / 2]);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const double ratio = errors[i] / scale_m;
    (*matches)[i].weight = 1.0 / std::pow(1.0 + ratio * ratio, 2);
  }
}

}  // namespace

void initialise_datum(GraphState* state) {
  constexpr double kWideEnoughM = 20.0;
  constexpr int kRounds = 10;
  if (state->has_datum && state->datum_spread_m > kWideEnoughM) return;
  std::vector<Match> matches = matches_of(*state);
  if (matches.empty()) return;
  Alignment alignment = align(matches);
  if (state->has_datum && alignment.spread_m < 1.5 * state->datum_spread_m) return;
  for (int round = 0; round < kRounds; ++round) {
    reweigh(alignment.T_W_G, &matches);
    alignment = align(matches);
  }
  state->estimate.datum = alignment.T_W_G;
  state->has_datum = true;
  state->datum_spread_m = alignment.spread_m;
}

}  // namespace voxnav::graph
