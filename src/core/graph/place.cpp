// SPDX-License-Identifier: BSD-3-Clause
#include "graph/place.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "graph/landmarks.hpp"

namespace voxnav::graph {
namespace {

using geometry::SurfacePoint;
using geometry::Vec3;

constexpr std::size_t kNeighbours = 8;
constexpr std::size_t kMaxTriangles = 2000;
constexpr float kShortest_m = 2.0f;
constexpr float kLongest_m = 25.0f;
constexpr float kStep_m = 0.5f;             // tolerance of a side
constexpr float kLeastDifference_m = 0.6f;  // two sides that differ less could be mistaken for each other

float length(const Vec3& a, const Vec3& b) { return static_cast<float>((a - b).head<2>().norm()); }

/// Makes the triangle of three landmarks, unless its sides are too short, too long or too similar to order its corners.
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
  const auto count = static_cast<std::uint16_t>(p.size());  // landmarks_of() bounds it
  for (std::uint16_t i = 0; i < count; ++i) {
    std::vector<std::uint16_t> near;
    near.reserve(count);
    for (std::uint16_t j = 0; j < count; ++j) {
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
  out.landmarks_S = landmarks_of(points);
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
  order.reserve(votes.size());
  for (const auto& [other, count] : votes) order.emplace_back(-count, other);
  std::sort(order.begin(), order.end());
  std::vector<int> out;
  for (const auto& [count, other] : order) {
    if (out.size() < static_cast<std::size_t>(limit)) out.push_back(other);
  }
  return out;
}

}  // namespace voxnav::graph
