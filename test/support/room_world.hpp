// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "voxnav/geometry/aabb.hpp"

namespace voxnav::test {

/// A room with boxes in it, seen from inside. Its ranges are exact, so that errors of poses can be measured to
/// millimetres.
struct RoomWorld {
  geometry::Aabb room;
  std::vector<geometry::Aabb> boxes;

  static RoomWorld hall() {
    RoomWorld w;
    w.room = {geometry::Vec3(-12, -9, -1.5), geometry::Vec3(14, 10, 5)};
    w.boxes = {{geometry::Vec3(4, 2, -1.5), geometry::Vec3(5, 4, 2)},
               {geometry::Vec3(-6, -5, -1.5), geometry::Vec3(-4, -4.5, 3)},
               {geometry::Vec3(2, -6, -1.5), geometry::Vec3(2.6, -5.4, 5)}};
    return w;
  }
  /// Returns a corridor that is so long that its ends along x are never seen.
  static RoomWorld corridor() {
    RoomWorld w;
    w.room = {geometry::Vec3(-1e5, -2, -1.2), geometry::Vec3(1e5, 2, 2)};
    return w;
  }

  double range(const geometry::Vec3& from, const geometry::Vec3& direction) const {
    double nearest = exit(room, from, direction);
    for (const geometry::Aabb& box : boxes) nearest = std::min(nearest, entry(box, from, direction));
    return nearest;
  }

 private:
  static void slabs(const geometry::Aabb& box, const geometry::Vec3& p, const geometry::Vec3& d, double* in,
                    double* out) {
    *in = -1e18;
    *out = 1e18;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = (box.min[axis] - p[axis]) / d[axis], b = (box.max[axis] - p[axis]) / d[axis];
      *in = std::max(*in, std::min(a, b));
      *out = std::min(*out, std::max(a, b));
    }
  }
  static double exit(const geometry::Aabb& box, const geometry::Vec3& p, const geometry::Vec3& d) {
    double in, out;
    slabs(box, p, d, &in, &out);
    return out;
  }
  static double entry(const geometry::Aabb& box, const geometry::Vec3& p, const geometry::Vec3& d) {
    double in, out;
    slabs(box, p, d, &in, &out);
    return in < out && in > 0 ? in : 1e18;
  }
};

struct RoomSweep {
  std::vector<geometry::Vec3f> points_L;
  std::vector<float> times_s;
};

/// Returns one sweep of a spinning LiDAR (32 beams, 360 columns, 0.1 s) whose pose in the world is a function of time.
inline RoomSweep sweep_of(const RoomWorld& world, const std::function<geometry::Pose(double)>& T_W_L, double start_s,
                          double noise_m, std::uint32_t seed, double max_range_m = 60.0) {
  constexpr int kBeams = 32, kColumns = 360;
  constexpr double kPi = 3.14159265358979323846;
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, noise_m);
  RoomSweep out;
  for (int c = 0; c < kColumns; ++c) {
    const double t = 0.1 * c / kColumns;
    const geometry::Pose pose = T_W_L(start_s + t);
    const double azimuth = -2 * kPi * c / kColumns + 0.001;
    for (int b = 0; b < kBeams; ++b) {
      const double elevation = (-45.0 + 90.0 * (b + 0.5) / kBeams) * kPi / 180;
      const geometry::Vec3 d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                             std::sin(elevation));
      const double range = world.range(pose.translation(), pose.linear() * d) + noise(random);
      if (range > max_range_m) continue;
      out.points_L.emplace_back((d * range).cast<float>());
      out.times_s.push_back(static_cast<float>(t));
    }
  }
  return out;
}

}  // namespace voxnav::test
