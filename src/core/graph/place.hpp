// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "graph/pose4.hpp"
#include "voxnav/geometry/distance_field.hpp"

/// Recognises a place by the constellation of its upright things (trunks, poles, corners), whatever the heading and
/// however far the estimate has drifted.
/// Source: Yuan et al., STD: Stable Triangle Descriptor for 3D place recognition, ICRA 2023, sections III-B to III-D;
/// differs: landmarks are columns found from above, as roll and pitch are known, so that triangles lie in the plane.
namespace voxnav::graph {

/// Three landmarks. v0 v1 is the shortest side, v0 v2 the longest: this names them whatever the heading.
struct LandmarkTriangle {
  std::uint16_t vertices[3];
  float sides_m[3];  ///< rising
  bool is_left;      ///< v0 v1 v2 turn left
};

/// What a submap looks like from afar.
struct Place {
  std::vector<geometry::Vec3> landmarks_S;  ///< foot of each upright thing, frame S
  std::vector<LandmarkTriangle> triangles;
};

/// O(points + landmarks). Deterministic. Landmarks and triangles are bounded.
Place describe_place(const std::vector<geometry::SurfacePoint>& points);

/// Key of a triangle's sides in steps of the tolerance, moved by whole steps.
std::uint32_t triangle_key(const LandmarkTriangle& triangle, int da = 0, int db = 0, int dc = 0);

struct PlaceMatch {
  Pose4 T_A_B = Pose4::Zero();
  int num_landmarks = 0;  ///< that stand at the same place in both
};

/// The relative pose at which most landmarks of the two agree; nothing when too few do or another pose explains nearly
/// as many. O(triangles * triangles of the same shape).
std::optional<PlaceMatch> match_places(const Place& a, const Place& b);

/// Which of many places have triangles of the same shape.
class PlaceIndex {
 public:
  void add(int id, const Place& place);
  /// Ids by the share of the place's triangles they hold too, most first; at most `limit`, itself left out.
  /// O(triangles * places that share a shape).
  std::vector<int> similar(int id, const Place& place, int limit) const;

 private:
  std::unordered_map<std::uint32_t, std::vector<int>> ids_;
};

}  // namespace voxnav::graph
