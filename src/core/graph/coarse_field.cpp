// SPDX-License-Identifier: BSD-3-Clause
#include "graph/coarse_field.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav::graph {
namespace {

constexpr double kMaxCells = 4e6;

}  // namespace

CoarseField::CoarseField(const std::vector<geometry::SurfacePoint>& points, double cell_m, double reach_m)
    : cell_m_(cell_m) {
  for (const geometry::SurfacePoint& point : points) {
    if (point.position.allFinite()) bounds_.extend(point.position.cast<double>());
  }
  if (bounds_.empty()) return;
  const geometry::Aabb box = bounds_.padded(reach_m);
  const geometry::Vec3 span = box.max - box.min;
  cell_m_ = std::max(cell_m, std::cbrt(span.prod() / kMaxCells));
  origin_ = box.min;
  std::size_t count = 1;
  for (int k = 0; k < 3; ++k) {
    size_[k] = static_cast<int>(std::ceil(span[k] / cell_m_)) + 1;
    count *= static_cast<std::size_t>(size_[k]);
  }
  distances_m_.assign(count, static_cast<float>(reach_m));
  for (const geometry::SurfacePoint& point : points) {
    if (point.position.allFinite()) stamp(point.position.cast<double>(), reach_m);
  }
}

void CoarseField::stamp(const geometry::Vec3& point, double reach_m) {
  int low[3];
  int high[3];
  for (int k = 0; k < 3; ++k) {
    const double at = point[k] - origin_[k];
    low[k] = std::max(0, static_cast<int>(std::ceil((at - reach_m) / cell_m_)));
    high[k] = std::min(size_[k] - 1, static_cast<int>(std::floor((at + reach_m) / cell_m_)));
  }
  const std::size_t length = static_cast<std::size_t>(size_[0]);
  const std::size_t layer = length * static_cast<std::size_t>(size_[1]);
  for (int z = low[2]; z <= high[2]; ++z) {
    for (int y = low[1]; y <= high[1]; ++y) {
      float* row = &distances_m_[static_cast<std::size_t>(z) * layer + static_cast<std::size_t>(y) * length];
      for (int x = low[0]; x <= high[0]; ++x) {
        const geometry::Vec3 node = origin_ + cell_m_ * geometry::Vec3(x, y, z);
        row[x] = std::min(row[x], static_cast<float>((node - point).norm()));
      }
    }
  }
}

bool CoarseField::sample(const geometry::Vec3& p_S, double* distance_m, geometry::Vec3* gradient) const {
  int i[3];
  double f[3];
  for (int k = 0; k < 3; ++k) {
    const double u = (p_S[k] - origin_[k]) / cell_m_;
    if (!(u >= 0.0) || !(u < size_[k] - 1)) return false;
    i[k] = static_cast<int>(u);
    f[k] = u - i[k];
  }
  const std::size_t dy = static_cast<std::size_t>(size_[0]);
  const std::size_t dz = dy * static_cast<std::size_t>(size_[1]);
  const float* c = &distances_m_[static_cast<std::size_t>(i[2]) * dz + static_cast<std::size_t>(i[1]) * dy +
                                 static_cast<std::size_t>(i[0])];
  const auto mix = [](double low, double high, double ratio) { return low + ratio * (high - low); };
  const double x00 = mix(c[0], c[1], f[0]);
  const double x10 = mix(c[dy], c[dy + 1], f[0]);
  const double x01 = mix(c[dz], c[dz + 1], f[0]);
  const double x11 = mix(c[dz + dy], c[dz + dy + 1], f[0]);
  const double y0 = mix(x00, x10, f[1]);
  const double y1 = mix(x01, x11, f[1]);
  *distance_m = mix(y0, y1, f[2]);
  if (gradient) {
    const double across0 = mix(c[1] - c[0], c[dy + 1] - c[dy], f[1]);
    const double across1 = mix(c[dz + 1] - c[dz], c[dz + dy + 1] - c[dz + dy], f[1]);
    *gradient = geometry::Vec3(mix(across0, across1, f[2]), mix(x10 - x00, x11 - x01, f[2]), y1 - y0) / cell_m_;
  }
  return true;
}

}  // namespace voxnav::graph
