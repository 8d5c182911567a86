// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "voxnav/geometry/aabb.hpp"

namespace voxnav::planning {

/// An upright prism: a polygon in the plane, at the heights from min_z to max_z, in metres.
struct Prism {
  std::vector<Eigen::Vector2d> outline;  ///< corners in order, either way round, the first one not repeated
  double min_z = 0.0;
  double max_z = 0.0;
};

/// Tells why a prism cannot be used, "" if it can: the outline needs three corners at least, all numbers must be
/// finite, edges must neither cross nor touch each other, and min_z must be below max_z. O(corners^2).
std::string problem_of(const Prism& prism);

/// What a fence is: the area that may not be left, or a zone that may not be entered.
enum class FenceKind { kArea, kZone };
constexpr auto words_of(FenceKind) { return std::array{"area", "zone"}; }

/// The fence that a place violates.
struct FenceContact {
  FenceKind kind = FenceKind::kArea;
  std::size_t zone = 0;  ///< number of the zone; 0 for the area
};

/// Where a segment first violates a fence.
struct FenceTouch {
  double t = 0.0;  ///< parameter on the segment from 0 to 1
  FenceContact contact;
};

/// The fences of a flight in one frame, exactly as they were given: at most one area, which bounds where the centre of
/// the vehicle may be, and zones, which are solid bodies that a ball of the vehicle's size may not touch. Immutable, so
/// that it may be used from several threads.
class Fences {
 public:
  /// @throws std::invalid_argument naming the prism that cannot be used, and why
  Fences(std::optional<Prism> area, std::vector<Prism> zones);

  const std::optional<Prism>& area() const { return area_; }
  const std::vector<Prism>& zones() const { return zones_; }

  /// Returns the fence that a place violates: it is outside the area, or within `radius_m` of a zone; nothing if it
  /// violates none. O(corners).
  std::optional<FenceContact> contact(const geometry::Vec3& point, double radius_m) const;

  /// Returns where a segment first leaves the area or comes within `radius_m` of a zone, to a millimetre on the safe
  /// side; nothing if it does not. Both ends must be finite. O(corners) for each step of at least a millimetre near
  /// zones.
  std::optional<FenceTouch> first_touch(const geometry::Vec3& from, const geometry::Vec3& to, double radius_m) const;
  /// As first_touch(), for the zones alone.
  std::optional<FenceTouch> first_zone_touch(const geometry::Vec3& from, const geometry::Vec3& to,
                                             double radius_m) const;

 private:
  std::optional<Prism> area_;
  std::vector<Prism> zones_;
  std::vector<geometry::Aabb> zone_boxes_;
};

}  // namespace voxnav::planning
