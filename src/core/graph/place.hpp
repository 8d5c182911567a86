// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "graph/pose4.hpp"
#include "voxnav/geometry/distance_field.hpp"

/// Recognises a place by the constellation of its upright things (trunks, poles, corners), independently of heading and
/// of how far the estimate has drifted.
/// Source: Yuan et al., STD: Stable Triangle Descriptor for 3D place recognition, ICRA 2023, sections III-B to III-D;
/// differs: landmarks are columns found from above, as roll and pitch are known, so that triangles lie in the plane.
namespace voxnav::graph {

/// A triangle of three landmarks. Its corners are ordered by the lengths of its sides, so that two submaps order the
/// same three landmarks alike: v0 v1 is the shortest side and v0 v2 the longest.
struct LandmarkTriangle {
  std::uint16_t vertices[3];
  float sides_m[3];  ///< lengths of the sides, rising
  bool is_left;      ///< whether v0, v1, v2 turn left
};

/// The landmarks of a submap and the triangles they form.
struct Place {
  std::vector<geometry::Vec3> landmarks_S;  ///< foot of each upright thing, frame S
  std::vector<LandmarkTriangle> triangles;
};

/// Finds the landmarks of a submap and their triangles; both are bounded in number. Deterministic. O(n log n).
Place describe_place(const std::vector<geometry::SurfacePoint>& points);

/// Returns the hash key of a triangle: its three sides in steps of the tolerance, and its handedness. `da`, `db` and
/// `dc` are added to the steps, to look up triangles whose sides differ by a step.
std::uint32_t triangle_key(const LandmarkTriangle& triangle, int da = 0, int db = 0, int dc = 0);

struct PlaceMatch {
  Pose4 T_A_B = Pose4::Zero();
  int num_landmarks = 0;  ///< landmarks that the two have in common at T_A_B
};

/// Returns the relative pose at which most landmarks of the two coincide; nothing if too few do, or if another pose
/// explains nearly as many. O(triangles * triangles of the same shape).
std::optional<PlaceMatch> match_places(const Place& a, const Place& b);

/// An index that finds, among many places, those that have triangles of the same shape.
class PlaceIndex {
 public:
  void add(int id, const Place& place);
  /// Returns the ids of at most `limit` places other than `id` that share most triangles with `place`, best first.
  /// O(triangles * places that share a shape).
  std::vector<int> similar(int id, const Place& place, int limit) const;

 private:
  std::unordered_map<std::uint32_t, std::vector<int>> ids_;
};

}  // namespace voxnav::graph
