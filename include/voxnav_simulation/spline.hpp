// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace voxnav_simulation {

/// A natural cubic spline through equally spaced points (x, y, z, heading): it is twice continuously differentiable,
/// and its acceleration is zero at both ends. Outside of its range its value is that of the nearer end point.
class Spline {
 public:
  using Point = Eigen::Vector4d;
  struct Value {
    Point position, velocity, acceleration, jerk;
  };

  Spline() = default;
  Spline(std::vector<Point> points, double dt_s);

  bool is_empty() const { return points_.empty(); }
  double duration_s() const { return points_.empty() ? 0 : dt_s_ * static_cast<double>(points_.size() - 1); }
  std::size_t index_at(double t_s) const;
  std::size_t size() const { return points_.size(); }
  Value at(double t_s) const;

 private:
  std::vector<Point> points_;
  std::vector<Point> curvatures_;  ///< second derivatives at the points
  double dt_s_ = 1;
};

}  // namespace voxnav_simulation
