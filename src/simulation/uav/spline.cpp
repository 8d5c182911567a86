// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/spline.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav_simulation {

Spline::Spline(std::vector<Point> points, double dt_s)
    : points_(std::move(points)), curvatures_(points_.size(), Point::Zero()), dt_s_(dt_s) {
  const std::size_t n = points_.size();
  if (n < 3) return;
  // The second derivatives m solve the tridiagonal system m[i-1] + 4 m[i] + m[i+1] = 6 / dt^2 times the second
  // differences of the points; it is solved by forward elimination and back substitution.
  std::vector<double> factor(n, 0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double pivot = 4 - factor[i - 1];
    factor[i] = 1 / pivot;
    const Point right = (points_[i + 1] - 2 * points_[i] + points_[i - 1]) * (6 / (dt_s_ * dt_s_));
    curvatures_[i] = (right - curvatures_[i - 1]) / pivot;
  }
  for (std::size_t i = n - 2; i >= 1; --i) curvatures_[i] -= factor[i] * curvatures_[i + 1];
}

std::size_t Spline::index_at(double t_s) const {
  if (t_s <= 0 || points_.size() < 2) return 0;
  return std::min(static_cast<std::size_t>(t_s / dt_s_), points_.size() - 1);
}

Spline::Value Spline::at(double t_s) const {
  Value out{Point::Zero(), Point::Zero(), Point::Zero(), Point::Zero()};
  if (points_.size() == 1 || t_s >= duration_s()) {
    out.position = points_.back();
    return out;
  }
  if (t_s < 0) {
    out.position = points_.front();
    return out;
  }
  const std::size_t i = std::min(index_at(t_s), points_.size() - 2);
  const double b = t_s / dt_s_ - static_cast<double>(i);
  const double a = 1 - b;
  const double h = dt_s_;
  const Point &p0 = points_[i], &p1 = points_[i + 1], &m0 = curvatures_[i], &m1 = curvatures_[i + 1];
  out.position = a * p0 + b * p1 + ((a * a * a - a) * m0 + (b * b * b - b) * m1) * (h * h / 6);
  out.velocity = (p1 - p0) / h + ((1 - 3 * a * a) * m0 + (3 * b * b - 1) * m1) * (h / 6);
  out.acceleration = a * m0 + b * m1;
  out.jerk = (m1 - m0) / h;
  return out;
}

}  // namespace voxnav_simulation
