// SPDX-License-Identifier: BSD-3-Clause
#include "graph/landmarks.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::graph {
namespace {

using geometry::Index3;
using geometry::SurfacePoint;
using geometry::Vec3;

constexpr double kGroundCell_m = 1.6;
constexpr double kColumn_m = 0.8;
constexpr double kLowest_m = 0.5;  // height above the ground; below it grass and stones stand upright, too
constexpr double kLevel_m = 0.5;
constexpr int kLevels = 8;
constexpr int kMinLevels = 5;  // number of the eight levels that must hold points
constexpr float kUprightNormalZ = 0.7f;
constexpr std::size_t kMaxLandmarks = 150;

/// A cell of a horizontal grid.
Index3 cell_of(const Vec3& p, double cell_m) {
  Index3 out = geometry::index_of(p, cell_m);
  out.z = 0;
  return out;
}

/// The height of the lowest point in each cell of a horizontal grid.
std::map<Index3, double> ground_of(const std::vector<SurfacePoint>& points) {
  std::map<Index3, double> lowest;
  for (const SurfacePoint& point : points) {
    const auto [at, is_new] =
        lowest.emplace(cell_of(point.position.cast<double>(), kGroundCell_m), static_cast<double>(point.position.z()));
    if (!is_new) at->second = std::min(at->second, static_cast<double>(point.position.z()));
  }
  return lowest;
}

double ground_around(const std::map<Index3, double>& ground, const Vec3& p) {
  const Index3 center = cell_of(p, kGroundCell_m);
  double out = p.z();
  for (int i = 0; i < 9; ++i) {
    const auto found = ground.find(center + Index3{i % 3 - 1, i / 3 - 1, 0});
    if (found != ground.end()) out = std::min(out, found->second);
  }
  return out;
}

struct Column {
  unsigned levels = 0;
  int count = 0;
  Vec3 sum = Vec3::Zero();  ///< sums of x and y of its points and of the ground heights below them
};

std::map<Index3, Column> columns_of(const std::vector<SurfacePoint>& points) {
  const std::map<Index3, double> ground = ground_of(points);
  std::map<Index3, Column> columns;
  for (const SurfacePoint& point : points) {
    if (std::abs(point.normal.z()) > kUprightNormalZ) continue;
    const Vec3 p = point.position.cast<double>();
    const double ground_m = ground_around(ground, p);
    const int level = static_cast<int>(std::floor((p.z() - ground_m - kLowest_m) / kLevel_m));
    if (level < 0 || level >= kLevels) continue;
    Column& column = columns[cell_of(p, kColumn_m)];
    column.levels |= 1u << level;
    ++column.count;
    column.sum += Vec3(p.x(), p.y(), ground_m);
  }
  return columns;
}

/// Returns one landmark for each column that holds more points than its eight neighbours, at the mean of all nine.
std::vector<Vec3> peaks_of(const std::map<Index3, Column>& columns) {
  std::vector<std::pair<int, Vec3>> found;
  for (const auto& [index, column] : columns) {
    Column all;
    bool is_highest = true;
    for (int i = 0; i < 9; ++i) {
      const auto beside = columns.find(index + Index3{i % 3 - 1, i / 3 - 1, 0});
      if (beside == columns.end()) continue;
      const bool is_before = beside->first < index;
      const int count = beside->second.count;
      is_highest = is_highest && (count < column.count || (count == column.count && !is_before));
      all.levels |= beside->second.levels;
      all.count += count;
      all.sum += beside->second.sum;
    }
    if (is_highest && __builtin_popcount(all.levels) >= kMinLevels) found.emplace_back(all.count, all.sum / all.count);
  }
  if (found.size() > kMaxLandmarks) {
    std::stable_sort(found.begin(), found.end(), [](const auto& l, const auto& r) { return l.first > r.first; });
    found.resize(kMaxLandmarks);
  }
  std::vector<Vec3> out;
  out.reserve(found.size());
  for (const auto& entry : found) out.push_back(entry.second);
  return out;
}

}  // namespace

std::vector<Vec3> landmarks_of(const std::vector<SurfacePoint>& points) { return peaks_of(columns_of(points)); }

}  // namespace voxnav::graph
