// SPDX-License-Identifier: BSD-3-Clause
#include "graph/place.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::graph {
namespace {

using geometry::Index3;
using geometry::SurfacePoint;
using geometry::Vec3;

constexpr double kGroundCell_m = 1.6;
constexpr double kColumn_m = 0.8;
constexpr double kLowest_m = 0.5;  // above the ground: below it grass and stones stand upright too
constexpr double kLevel_m = 0.5;
constexpr int kLevels = 8;
constexpr int kMinLevels = 5;  // of the eight that must hold something for a landmark
constexpr float kUprightNormalZ = 0.7f;
constexpr std::size_t kMaxLandmarks = 150;
constexpr std::size_t kNeighbours = 8;
constexpr std::size_t kMaxTriangles = 2000;
constexpr float kShortest_m = 2.0f;
constexpr float kLongest_m = 25.0f;
constexpr float kStep_m = 0.5f;             // tolerance of a side
constexpr float kLeastDifference_m = 0.6f;  // sides nearer to each other could be taken for one another

/// Cell of the ground plan.
Index3 cell_of(const Vec3& p, double cell_m) {
  Index3 out = geometry::index_of(p, cell_m);
  out.z = 0;
  return out;
}

/// Lowest point of each cell of the ground plan.
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
  Vec3 sum = Vec3::Zero();  ///< x, y of its points, ground below them
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

/// Columns that hold more points than those beside them, together with these.
std::vector<Vec3> landmarks_of(const std::map<Index3, Column>& columns) {
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
  for (const auto& entry : found) out.push_back(entry.second);
  return out;
}

float length(const Vec3& a, const Vec3& b) { return static_cast<float>((a - b).head<2>().norm()); }

/// Nothing when the sides do not name the corners.
std::optional<LandmarkTriangle> triangle_of(const std::vector<Vec3>& p, const std::array<std::uint16_t, 3>& corners) {
  struct Side {
    float length_m;
    int opposite;
  };
  std::array<Side, 3> sides;
  for (int k = 0; k < 3; ++k) sides[k] = {length(p[corners[(k + 1) % 3]], p[corners[(k + 2) % 3]]), k};
  std::sort(sides.begin(), sides.end(), [](const Side& l, const Side& r) { return l.length_m < r.length_m; });
  if (sides[0].length_m < kShortest_m || sides[2].length_m > kLongest_m) return std::nullopt;
  if (sides[1].length_m - sides[0].length_m < kLeastDifference_m) return std::nullopt;
  if (sides[2].length_m - sides[1].length_m < kLeastDifference_m) return std::nullopt;
  LandmarkTriangle out;
  // The shortest and the longest side meet where the middle one is opposite.
  out.vertices[0] = corners[sides[1].opposite];
  out.vertices[1] = corners[sides[2].opposite];
  out.vertices[2] = corners[sides[0].opposite];
  for (int k = 0; k < 3; ++k) out.sides_m[k] = sides[k].length_m;
  const Vec3 u = p[out.vertices[1]] - p[out.vertices[0]];
  const Vec3 v = p[out.vertices[2]] - p[out.vertices[0]];
  out.is_left = u.x() * v.y() - u.y() * v.x() > 0.0;
  return out;
}

std::vector<LandmarkTriangle> triangles_of(const std::vector<Vec3>& p) {
  std::set<std::array<std::uint16_t, 3>> triples;
  for (std::uint16_t i = 0; i < p.size(); ++i) {
    std::vector<std::uint16_t> near;
    for (std::uint16_t j = 0; j < p.size(); ++j) {
      if (j != i) near.push_back(j);
    }
    const std::size_t kept = std::min(kNeighbours, near.size());
    std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(kept), near.end(),
                      [&](int l, int r) { return length(p[i], p[l]) < length(p[i], p[r]); });
    for (std::size_t j = 0; j < kept; ++j) {
      for (std::size_t k = j + 1; k < kept; ++k) {
        std::array<std::uint16_t, 3> triple{i, near[j], near[k]};
        std::sort(triple.begin(), triple.end());
        triples.insert(triple);
      }
    }
  }
  std::vector<LandmarkTriangle> out;
  for (const auto& triple : triples) {
    if (const auto triangle = triangle_of(p, triple)) out.push_back(*triangle);
    if (out.size() >= kMaxTriangles) break;
  }
  return out;
}

}  // namespace

Place describe_place(const std::vector<SurfacePoint>& points) {
  Place out;
  out.landmarks_S = landmarks_of(columns_of(points));
  out.triangles = triangles_of(out.landmarks_S);
  return out;
}

std::uint32_t triangle_key(const LandmarkTriangle& triangle, int da, int db, int dc) {
  const auto step = [&](int k, int moved) {
    return static_cast<std::uint32_t>(static_cast<int>(triangle.sides_m[k] / kStep_m) + moved) & 1023u;
  };
  return (step(0, da) << 21) | (step(1, db) << 11) | (step(2, dc) << 1) | (triangle.is_left ? 1u : 0u);
}

void PlaceIndex::add(int id, const Place& place) {
  for (const LandmarkTriangle& triangle : place.triangles) {
    std::vector<int>& ids = ids_[triangle_key(triangle)];
    if (ids.empty() || ids.back() != id) ids.push_back(id);
  }
}

std::vector<int> PlaceIndex::similar(int id, const Place& place, int limit) const {
  std::map<int, int> votes;
  for (const LandmarkTriangle& triangle : place.triangles) {
    const auto found = ids_.find(triangle_key(triangle));
    if (found == ids_.end()) continue;
    for (const int other : found->second) {
      if (other != id) ++votes[other];
    }
  }
  std::vector<std::pair<int, int>> order;
  for (const auto& [other, count] : votes) order.emplace_back(-count, other);
  std::sort(order.begin(), order.end());
  std::vector<int> out;
  for (const auto& [count, other] : order) {
    if (out.size() < static_cast<std::size_t>(limit)) out.push_back(other);
  }
  return out;
}

}  // namespace voxnav::graph
