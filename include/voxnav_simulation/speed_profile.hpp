// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "voxnav_simulation/dynamics_limits.hpp"
#include "voxnav_simulation/kinematic_state.hpp"

namespace voxnav_simulation {

/// Straight segments between distinct vertices, on which points are named by their arc length.
class Polyline {
 public:
  explicit Polyline(std::vector<Vec3> vertices);

  const std::vector<Vec3>& vertices() const { return vertices_; }
  std::size_t num_segments() const { return vertices_.size() - 1; }
  double length_m() const { return arcs_.back(); }
  double arc(std::size_t vertex) const { return arcs_[vertex]; }
  Vec3 direction(std::size_t segment) const;
  /// Returns the cosine of half the interior angle at a vertex: 0 where the line goes straight on, 1 where it turns
  /// back.
  double turn(std::size_t vertex) const;
  Vec3 at(std::size_t segment, double arc_m) const;
  /// Returns the distance from `p` to the nearest of the segments [first, last].
  double distance(const Vec3& p, std::size_t first, std::size_t last) const;

 private:
  std::vector<Vec3> vertices_;
  std::vector<double> arcs_;
};

/// The speed along a polyline as a function of arc length. Every node has a highest speed, and the profile is the
/// fastest one below them that respects the tangential acceleration; one backward and one forward pass find it.
class SpeedProfile {
 public:
  /// @param reserves_m  for each vertex, the distance below which only part of the acceleration is used along the path,
  ///                    because the turn needs the rest
  SpeedProfile(const Polyline& path, const TrackerLimits& limits, const std::vector<double>& reserves_m);

  void cap_vertex(std::size_t vertex, double speed);
  void scale_caps(double first_arc_m, double last_arc_m, double ratio);
  /// Computes the profile. @return false if the start speed is too high to brake for the speeds allowed farther on
  bool solve(double start_speed);

  struct Sample {
    Vec3 position;
    std::size_t segment;
    double arc_m;
  };
  /// Returns the positions at every `dt_s`. At vertices where the speed is zero the point waits for `dwell_s`.
  /// The list is empty if more than `max_samples` would be needed.
  std::vector<Sample> sample(double dt_s, double dwell_s, std::size_t max_samples) const;

 private:
  struct Node {
    double arc_m;
    std::size_t segment;  ///< the segment that starts at this node or contains it
    double cap;
    double acceleration;  ///< along the path from this node to the next
    double speed;
    bool is_vertex;
  };
  const Polyline* path_;
  std::vector<Node> nodes_;
};

}  // namespace voxnav_simulation
