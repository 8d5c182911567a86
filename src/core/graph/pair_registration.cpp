// SPDX-License-Identifier: BSD-3-Clause
#include "graph/pair_registration.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav::graph {
namespace {

using geometry::Vec3;

/// Chooses at most `max_points` points of `from` that lie in the observed part of `into`.
/// @param ratio  receives the share of all points of `from` that lie there
std::vector<std::uint32_t> points_inside(const SurfaceSample& from, const SurfaceSample& into,
                                         const geometry::Pose& T_into_from, int max_points, double* ratio) {
  std::vector<std::uint32_t> out;
  double distance_m = 0.0;
  for (std::uint32_t i = 0; i < from.points.size(); ++i) {
    if (into.field->sample(T_into_from * from.points[i].position_S, &distance_m, nullptr)) out.push_back(i);
  }
  *ratio = from.points.empty() ? 0.0 : static_cast<double>(out.size()) / static_cast<double>(from.points.size());
  if (out.size() > static_cast<std::size_t>(max_points)) out.resize(static_cast<std::size_t>(max_points));
  return out;
}

/// Sums over the points of a pair, from which evaluate_pair() takes the means.
struct Sums {
  double kernel2;
  double weight = 0.0;
  double matched = 0.0;
  double cost = 0.0;
  Pose4 gradient = Pose4::Zero();
  Matrix4 hessian = Matrix4::Zero();
  Eigen::Vector2d first = Eigen::Vector2d::Zero();
  double second = 0.0;

  void add_lost(double w) {
    weight += w;
    cost += w * kernel2;
  }
  void add(double w, double residual, const Pose4& jacobian, const Eigen::Vector2d& p_A) {
    const double shrink = kernel2 / (kernel2 + residual * residual);
    weight += w;
    matched += w;
    cost += w * residual * residual * shrink;
    const double pull = w * shrink * shrink;
    gradient += pull * residual * jacobian;
    hessian.noalias() += pull * jacobian * jacobian.transpose();
    first += w * p_A;
    second += w * p_A.squaredNorm();
  }
};

/// Returns the part of a gradient that a point may use. Near the edge of the observed part of a plane, the distance
/// field slopes towards that edge, and between surface points it ripples. Neither is information about the plane, so
/// for a point in a plane only the component along its normal counts.
Vec3 believed(const Vec3& slope, const SamplePoint& point, const Vec3& normal) {
  return point.is_planar ? Vec3(slope.dot(normal) * normal) : slope;
}

/// One submap of a pair with its drift taken out: all its content is moved to where it would lie if the submap had seen
/// it at the mean time at which it saw what the pair shares.
class Steady {
 public:
  Steady(const SurfaceSample& sample, double phase)
      : sample_(sample), is_rigid_(sample.sway.is_none()), mean_(sample.sway.at(phase)) {}
  Vec3 position(const SamplePoint& point) const {
    return is_rigid_ ? point.position_S : Vec3(point.position_S + sample_.sway.at(point.phase) - mean_);
  }
  bool sample(const Vec3& p, double* distance_m, Vec3* slope) const {
    if (is_rigid_) return sample_.field->sample(p, distance_m, slope);
    return sample_.field->sample(p - sample_.sway.at(sample_.phases.at(p)) + mean_, distance_m, slope);
  }

 private:
  const SurfaceSample& sample_;
  bool is_rigid_;
  Vec3 mean_;
};

/// Returns the mean phase, 0 to 1, at which the submap saw the given points.
double mean_phase(const SurfaceSample& sample, const std::vector<std::uint32_t>& points) {
  double weight = 0.0;
  double sum = 0.0;
  for (const std::uint32_t i : points) {
    weight += sample.points[i].weight;
    sum += sample.points[i].weight * sample.points[i].phase;
  }
  return weight > 0.0 ? sum / weight : 0.5;
}

/// Points of B in the field of A: q = R p + t.
void add_b_in_a(const SurfaceSample& a, const SurfaceSample& b, const PairOverlap& overlap, const Pose4& T,
                Sums* sums) {
  const double c = std::cos(T[3]);
  const double s = std::sin(T[3]);
  const Steady steady_a(a, overlap.phase_a), steady_b(b, overlap.phase_b);
  for (const std::uint32_t i : overlap.of_b) {
    const SamplePoint& point = b.points[i];
    const Vec3 p = steady_b.position(point);
    const Vec3 q(c * p.x() - s * p.y() + T[0], s * p.x() + c * p.y() + T[1], p.z() + T[2]);
    double distance_m = 0.0;
    Vec3 slope;
    if (!steady_a.sample(q, &distance_m, &slope)) {
      sums->add_lost(point.weight);
      continue;
    }
    const Vec3& n = point.normal_S;
    slope = believed(slope, point, {c * n.x() - s * n.y(), s * n.x() + c * n.y(), n.z()});
    const double turn = slope.x() * (-s * p.x() - c * p.y()) + slope.y() * (c * p.x() - s * p.y());
    sums->add(point.weight, distance_m - point.own_distance_m, Pose4(slope.x(), slope.y(), slope.z(), turn),
              q.head<2>());
  }
}

/// Points of A in the field of B: q = Rᵀ (p − t).
void add_a_in_b(const SurfaceSample& a, const SurfaceSample& b, const PairOverlap& overlap, const Pose4& T,
                Sums* sums) {
  const double c = std::cos(T[3]);
  const double s = std::sin(T[3]);
  const Steady steady_a(a, overlap.phase_a), steady_b(b, overlap.phase_b);
  for (const std::uint32_t i : overlap.of_a) {
    const SamplePoint& point = a.points[i];
    const Vec3 p = steady_a.position(point);
    const Vec3 d = p - T.head<3>();
    const Vec3 q(c * d.x() + s * d.y(), -s * d.x() + c * d.y(), d.z());
    double distance_m = 0.0;
    Vec3 slope;
    if (!steady_b.sample(q, &distance_m, &slope)) {
      sums->add_lost(point.weight);
      continue;
    }
    const Vec3& n = point.normal_S;
    slope = believed(slope, point, {c * n.x() + s * n.y(), -s * n.x() + c * n.y(), n.z()});
    const Pose4 jacobian(-c * slope.x() + s * slope.y(), -s * slope.x() - c * slope.y(), -slope.z(),
                         slope.x() * q.y() - slope.y() * q.x());
    sums->add(point.weight, distance_m - point.own_distance_m, jacobian, p.head<2>());
  }
}

}  // namespace

PairOverlap find_overlap(const SurfaceSample& a, const SurfaceSample& b, const Pose4& T_A_B, int max_points) {
  PairOverlap out;
  double ratio_a = 0.0;
  double ratio_b = 0.0;
  const geometry::Pose T = to_pose(T_A_B);
  out.of_b = points_inside(b, a, T, max_points, &ratio_b);
  out.of_a = points_inside(a, b, T.inverse(), max_points, &ratio_a);
  out.ratio = std::max(ratio_a, ratio_b);
  out.phase_a = mean_phase(a, out.of_a);
  out.phase_b = mean_phase(b, out.of_b);
  return out;
}

double cost_up_to(const SurfaceSample& a, const SurfaceSample& b, const PairOverlap& overlap, const Pose4& T_A_B,
                  double kernel_m, double enough_m2) {
  const double kernel2 = kernel_m * kernel_m;
  double total = 0.0;
  for (const std::uint32_t i : overlap.of_a) total += a.points[i].weight;
  for (const std::uint32_t i : overlap.of_b) total += b.points[i].weight;
  double cost = 0.0;
  const double enough = enough_m2 * total;
  const auto add = [&](const SamplePoint& point, const geometry::DistanceField& field, const Vec3& q) {
    double distance_m = 0.0;
    if (!field.sample(q, &distance_m, nullptr)) {
      cost += point.weight * kernel2;
      return;
    }
    const double residual = distance_m - point.own_distance_m;
    cost += point.weight * residual * residual * kernel2 / (kernel2 + residual * residual);
  };
  const geometry::Pose T = to_pose(T_A_B), T_B_A = T.inverse();
  for (std::size_t k = 0; k < std::max(overlap.of_a.size(), overlap.of_b.size()) && cost < enough; ++k) {
    if (k < overlap.of_b.size()) {
      const SamplePoint& point = b.points[overlap.of_b[k]];
      add(point, *a.field, T * point.position_S);
    }
    if (k < overlap.of_a.size()) {
      const SamplePoint& point = a.points[overlap.of_a[k]];
      add(point, *b.field, T_B_A * point.position_S);
    }
  }
  return total > 0.0 ? cost / total : kernel2;
}

PairModel evaluate_pair(const SurfaceSample& a, const SurfaceSample& b, const PairOverlap& overlap, const Pose4& T_A_B,
                        double kernel_m) {
  Sums sums;
  sums.kernel2 = kernel_m * kernel_m;
  add_b_in_a(a, b, overlap, T_A_B, &sums);
  add_a_in_b(a, b, overlap, T_A_B, &sums);
  PairModel out;
  out.T_A_B = T_A_B;
  out.cost_m2 = sums.kernel2;
  if (sums.matched <= 0.0) return out;
  out.cost_m2 = sums.cost / sums.weight;
  out.gradient = sums.gradient / sums.weight;
  out.hessian = sums.hessian / sums.weight;
  out.matched_ratio = sums.matched / sums.weight;
  out.center_A = sums.first / sums.matched;
  out.radius_m = std::sqrt(std::max(1.0, sums.second / sums.matched - out.center_A.squaredNorm()));
  return out;
}

}  // namespace voxnav::graph
