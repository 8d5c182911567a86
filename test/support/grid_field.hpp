// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "voxnav/geometry/distance_field.hpp"

/// Analytic worlds and distance fields of them, for tests of registration that must not depend on the making of
/// submaps.
namespace voxnav::test_support {

using geometry::Pose;
using geometry::SurfacePoint;
using geometry::Vec3;

/// A distance function that is sampled on a grid and interpolated trilinearly, as in submaps. It is unobserved outside
/// its box.
class GridField final : public geometry::DistanceField {
 public:
  GridField(const geometry::Aabb& box, double resolution_m, const std::function<double(const Vec3&)>& distance,
            std::vector<SurfacePoint> points)
      : min_(box.min), resolution_m_(resolution_m), points_(std::move(points)) {
    for (int k = 0; k < 3; ++k) size_[k] = static_cast<int>((box.max[k] - box.min[k]) / resolution_m) + 1;
    for (int z = 0; z < size_[2]; ++z) {
      for (int y = 0; y < size_[1]; ++y) {
        for (int x = 0; x < size_[0]; ++x) {
          values_.push_back(static_cast<float>(distance(min_ + resolution_m * Vec3(x, y, z))));
        }
      }
    }
    for (const SurfacePoint& point : points_) bounds_.extend(point.position.cast<double>());
  }

  bool sample(const Vec3& p_S, double* distance_m, Vec3* gradient) const override {
    const Vec3 u = (p_S - min_) / resolution_m_;
    int i[3];
    double f[3];
    for (int k = 0; k < 3; ++k) {
      if (!(u[k] >= 0.0) || !(u[k] < size_[k] - 1)) return false;
      i[k] = static_cast<int>(u[k]);
      f[k] = u[k] - i[k];
    }
    double corner[2][2][2];
    for (int c = 0; c < 8; ++c)
      corner[c >> 2][(c >> 1) & 1][c & 1] = at(i[0] + (c & 1), i[1] + ((c >> 1) & 1), i[2] + (c >> 2));
    interpolate(corner, f, distance_m, gradient);
    return true;
  }

  const std::vector<SurfacePoint>& surface_points() const override { return points_; }
  geometry::Aabb surface_bounds() const override { return bounds_; }
  double resolution_m() const override { return resolution_m_; }

 private:
  double at(int x, int y, int z) const {
    const int number = (z * size_[1] + y) * size_[0] + x;
    return values_[static_cast<std::size_t>(number)];
  }
  void interpolate(const double (&c)[2][2][2], const double (&f)[3], double* distance_m, Vec3* gradient) const {
    double value = 0.0;
    Vec3 slope = Vec3::Zero();
    for (int k = 0; k < 8; ++k) {
      const int bit[3] = {k & 1, (k >> 1) & 1, k >> 2};
      double w[3];
      for (int a = 0; a < 3; ++a) w[a] = bit[a] ? f[a] : 1.0 - f[a];
      const double v = c[bit[2]][bit[1]][bit[0]];
      value += v * w[0] * w[1] * w[2];
      for (int a = 0; a < 3; ++a) slope[a] += v * (bit[a] ? 1.0 : -1.0) * w[(a + 1) % 3] * w[(a + 2) % 3];
    }
    *distance_m = value;
    if (gradient) *gradient = slope / resolution_m_;
  }

  Vec3 min_;
  double resolution_m_;
  int size_[3];
  std::vector<float> values_;
  std::vector<SurfacePoint> points_;
  geometry::Aabb bounds_;
};

struct Trunk {
  double x_m;
  double y_m;
  double radius_m;
};

/// Upright trunks on gently rolling ground.
struct ForestWorld {
  std::vector<Trunk> trunks;
  double hill_m = 0.3;

  double ground(double x, double y) const { return hill_m * std::sin(0.15 * x) * std::cos(0.12 * y); }
  double distance(const Vec3& p) const {
    double out = p.z() - ground(p.x(), p.y());
    for (const Trunk& t : trunks) out = std::min(out, std::hypot(p.x() - t.x_m, p.y() - t.y_m) - t.radius_m);
    return std::max(-0.4, std::min(3.0, out));
  }
};

/// Returns `per_hectare` trunks in a square of half width `half_m`. The same seed gives the same forest.
inline ForestWorld make_forest(double half_m, double per_hectare, unsigned seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> position(-half_m, half_m);
  std::uniform_real_distribution<double> radius(0.1, 0.3);
  ForestWorld world;
  const auto count = static_cast<int>(per_hectare * 4.0 * half_m * half_m / 1e4);
  for (int i = 0; i < count; ++i) {
    const double x_m = position(rng);
    const double y_m = position(rng);
    world.trunks.push_back({x_m, y_m, radius(rng)});
  }
  return world;
}

struct View {
  double range_m = 16.0;
  double height_m = 6.0;
  double resolution_m = 0.4;
  double noise_m = 0.03;
  unsigned seed = 1;
};

/// Returns surface points of the world within range of the submap's origin, in frame S.
inline std::vector<SurfacePoint> observe(const ForestWorld& world, const Pose& T_W_S, const View& view) {
  std::mt19937 rng(view.seed);
  std::normal_distribution<double> noise(0.0, view.noise_m);
  const Pose T_S_W = T_W_S.inverse();
  std::vector<SurfacePoint> out;
  const auto add = [&](const Vec3& p_W, const Vec3& n_W) {
    const Vec3 p_S = T_S_W * (p_W + noise(rng) * n_W);
    if (p_S.head<2>().norm() > view.range_m) return;
    out.push_back({p_S.cast<float>(), (T_S_W.linear() * n_W).cast<float>(), 1.0f});
  };
  const Vec3 center = T_W_S.translation();
  const int across = static_cast<int>(std::ceil(2.0 * view.range_m / 0.8));
  for (int i = 0; i < across; ++i) {
    for (int j = 0; j < across; ++j) {
      const double x = center.x() - view.range_m + 0.8 * i, y = center.y() - view.range_m + 0.8 * j;
      add({x, y, world.ground(x, y)}, Vec3::UnitZ());
    }
  }
  for (const Trunk& t : world.trunks) {
    for (int level = 1; 0.4 * level < view.height_m; ++level) {
      const double z = 0.4 * level;
      for (int k = 0; k < 5; ++k) {
        const double angle = 2.0 * M_PI * k / 5.0 + z;
        const Vec3 n(std::cos(angle), std::sin(angle), 0.0);
        add(Vec3(t.x_m, t.y_m, world.ground(t.x_m, t.y_m) + z) + t.radius_m * n, n);
      }
    }
  }
  return out;
}

/// Returns the distance field of a submap of the world at a pose.
inline std::shared_ptr<GridField> make_submap(const ForestWorld& world, const Pose& T_W_S, const View& view) {
  ForestWorld near;  // without the trunks out of reach, which would only cost time
  near.hill_m = world.hill_m;
  for (const Trunk& t : world.trunks) {
    if ((Vec3(t.x_m, t.y_m, 0) - T_W_S.translation()).head<2>().norm() < 1.5 * view.range_m + 4.0)
      near.trunks.push_back(t);
  }
  const double z_W = T_W_S.translation().z();
  const geometry::Aabb box{Vec3(-view.range_m, -view.range_m, -2.0 - z_W),
                           Vec3(view.range_m, view.range_m, view.height_m + 1.0 - z_W)};
  return std::make_shared<GridField>(
      box, view.resolution_m, [&](const Vec3& p_S) { return near.distance(T_W_S * p_S); }, observe(near, T_W_S, view));
}

}  // namespace voxnav::test_support
