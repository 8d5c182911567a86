// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/speed_profile.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voxnav_simulation {
namespace {

constexpr double kNodeSpacing_m = 0.05;
constexpr double kMaxNodes = 20000;
constexpr double kTangentialShareNearTurns = 0.6;

/// Returns the largest multiple of a unit vector whose horizontal and vertical parts stay within their limits.
double along(const Vec3& direction, double horizontal, double vertical) {
  const double h = direction.head<2>().norm();
  const double v = std::abs(direction.z());
  return std::min(h > 1e-9 ? horizontal / h : std::numeric_limits<double>::infinity(),
                  v > 1e-9 ? vertical / v : std::numeric_limits<double>::infinity());
}

}  // namespace

Polyline::Polyline(std::vector<Vec3> vertices) : vertices_(std::move(vertices)) {
  arcs_.push_back(0);
  for (std::size_t i = 1; i < vertices_.size(); ++i) {
    arcs_.push_back(arcs_.back() + (vertices_[i] - vertices_[i - 1]).norm());
  }
}

Vec3 Polyline::direction(std::size_t segment) const {
  return (vertices_[segment + 1] - vertices_[segment]).normalized();
}

double Polyline::turn(std::size_t vertex) const {
  if (vertex == 0 || vertex + 1 >= vertices_.size()) return 0;
  return 0.5 * (direction(vertex) - direction(vertex - 1)).norm();
}

Vec3 Polyline::at(std::size_t segment, double arc_m) const {
  const double length = arcs_[segment + 1] - arcs_[segment];
  const double ratio = std::clamp((arc_m - arcs_[segment]) / length, 0.0, 1.0);
  return vertices_[segment] + ratio * (vertices_[segment + 1] - vertices_[segment]);
}

double Polyline::distance(const Vec3& p, std::size_t first, std::size_t last) const {
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = first; i <= last; ++i) {
    const Vec3 edge = vertices_[i + 1] - vertices_[i];
    const double ratio = std::clamp((p - vertices_[i]).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    best = std::min(best, (vertices_[i] + ratio * edge - p).norm());
  }
  return best;
}

SpeedProfile::SpeedProfile(const Polyline& path, const TrackerLimits& limits, const std::vector<double>& reserves_m)
    : path_(&path) {
  const double spacing = std::max(kNodeSpacing_m, path.length_m() / kMaxNodes);
  for (std::size_t s = 0; s < path.num_segments(); ++s) {
    const Vec3 direction = path.direction(s);
    const TrackerAxisLimits& vertical = direction.z() > 0 ? limits.ascending : limits.descending;
    const double speed = along(direction, limits.horizontal.speed, vertical.speed);
    const double acceleration = along(direction, limits.horizontal.acceleration, limits.vertical_acceleration());
    const double length = path.arc(s + 1) - path.arc(s);
    const auto count = static_cast<int>(std::ceil(length / spacing));
    for (int i = 0; i < count; ++i) {
      const double from_start = length * i / count;
      const bool near_turn = from_start < reserves_m[s] || length - from_start < reserves_m[s + 1];
      const double share = near_turn ? kTangentialShareNearTurns : 1.0;
      nodes_.push_back({path.arc(s) + from_start, s, speed, acceleration * share, 0, i == 0});
    }
    if (s > 0) {
      Node& corner = nodes_[nodes_.size() - static_cast<std::size_t>(count)];
      corner.cap = std::min(corner.cap, nodes_[nodes_.size() - static_cast<std::size_t>(count) - 1].cap);
    }
  }
  nodes_.push_back({path.length_m(), path.num_segments() - 1, 0, 0, 0, true});
}

void SpeedProfile::cap_vertex(std::size_t vertex, double speed) {
  const double arc = path_->arc(vertex);
  for (Node& node : nodes_) {
    if (node.is_vertex && std::abs(node.arc_m - arc) < 1e-9) node.cap = std::min(node.cap, speed);
  }
}

void SpeedProfile::scale_caps(double first_arc_m, double last_arc_m, double ratio) {
  auto first = std::lower_bound(nodes_.begin(), nodes_.end(), first_arc_m,
                                [](const Node& node, double arc) { return node.arc_m < arc; });
  if (first != nodes_.begin()) --first;
  for (auto it = first; it != nodes_.end(); ++it) {
    it->cap = std::min(it->cap, std::max(it->speed, 0.02)) * ratio;
    if (it->arc_m > last_arc_m) break;
  }
}

bool SpeedProfile::solve(double start_speed) {
  for (Node& node : nodes_) node.speed = node.cap;
  nodes_.front().speed = start_speed;
  nodes_.back().speed = 0;
  for (std::size_t i = nodes_.size() - 1; i-- > 1;) {
    const double length = nodes_[i + 1].arc_m - nodes_[i].arc_m;
    const double reachable = std::sqrt(std::pow(nodes_[i + 1].speed, 2) + 2 * nodes_[i].acceleration * length);
    nodes_[i].speed = std::min(nodes_[i].speed, reachable);
  }
  for (std::size_t i = 1; i < nodes_.size(); ++i) {
    const double length = nodes_[i].arc_m - nodes_[i - 1].arc_m;
    const double room = 2 * nodes_[i - 1].acceleration * length;
    const double before = std::pow(nodes_[i - 1].speed, 2);
    nodes_[i].speed = std::min(nodes_[i].speed, std::sqrt(before + room));
    // If the vehicle is faster at the start than the profile allows, it brakes as hard as allowed. It may exceed the
    // speeds of nodes on straight lines meanwhile, but not those of corners.
    const double slowest = std::sqrt(std::max(0.0, before - room * (1 + 1e-9)));
    if (nodes_[i].speed < slowest - 1e-6) {
      if (nodes_[i].is_vertex || nodes_[i].cap < 0.05) return false;
      nodes_[i].speed = slowest;
    }
  }
  return true;
}

std::vector<SpeedProfile::Sample> SpeedProfile::sample(double dt_s, double dwell_s, std::size_t max_samples) const {
  std::vector<Sample> out;
  double time = 0;  // the time at the first node of the interval
  std::size_t next = 0;
  for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
    const Node& a = nodes_[i];
    const Node& b = nodes_[i + 1];
    const double length = b.arc_m - a.arc_m;
    const double mean = std::max(0.5 * (a.speed + b.speed), 1e-3);
    const double duration = length / mean;
    if ((time + duration + dwell_s) / dt_s > static_cast<double>(max_samples)) return {};
    if (i > 0 && a.is_vertex && a.speed <= 0) {
      for (; static_cast<double>(next) * dt_s < time + dwell_s; ++next)
        out.push_back({path_->at(a.segment, a.arc_m), a.segment, a.arc_m});
      time += dwell_s;
    }
    const double acceleration = (b.speed - a.speed) / duration;
    for (; static_cast<double>(next) * dt_s < time + duration; ++next) {
      const double t = static_cast<double>(next) * dt_s - time;
      const double arc = std::clamp(a.arc_m + a.speed * t + 0.5 * acceleration * t * t, a.arc_m, b.arc_m);
      out.push_back({path_->at(a.segment, arc), a.segment, arc});
    }
    time += duration;
  }
  out.push_back({path_->vertices().back(), path_->num_segments() - 1, path_->length_m()});
  return out;
}

}  // namespace voxnav_simulation
