// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "planning/sightings.hpp"
#include "voxnav/containers/state_grid.hpp"
#include "voxnav/pipeline/navigation_map.hpp"
#include "voxnav/planning/occupancy_view.hpp"

namespace voxnav::pipeline {

/// What the newest sweep showed beside the local map, on the voxels of the local map.
class PlacedSightings {
 public:
  /// @param others  UAVs that announce where they will be, null for none
  PlacedSightings(const NavigationMapConfig& config, const SweepSightings& sweep, planning::SharedOthers others);

  double resolution_m() const { return resolution_m_; }
  const planning::Sightings& sightings() const { return sightings_; }
  /// Whether there is something in a voxel although the map believes that it is free.
  bool is_hit(const geometry::Index3& voxel) const;
  /// Makes the voxels of a block occupied in which there is something. Returns false if there are none.
  bool add_hits(const geometry::Index3& block, containers::StateBlock* states) const;
  bool has_hits(const geometry::Index3& block) const { return hits_.count(block) > 0; }
  /// ORs the voxels of a block where things will be, with the room that is kept from them, and those where a vehicle
  /// that flies there may meet another UAV. Returns false if there are none.
  bool forbid(const geometry::Index3& block, const geometry::Vec3& vehicle, planning::BlockMask* mask) const;
  /// Boxes around the places where things and other UAVs will be.
  std::vector<geometry::Aabb> boxes() const;

 private:
  geometry::Aabb box_of(const containers::MovingThing& thing) const;
  bool is_forbidden(const containers::MovingThing& thing, const geometry::Vec3& center) const;

  bool forbid_things(const geometry::Index3& block, planning::BlockMask* mask) const;
  bool forbid_others(const geometry::Index3& block, const geometry::Vec3& vehicle, planning::BlockMask* mask) const;

  double resolution_m_;
  double clearance_m_;
  double meeting_speed_mps_;
  planning::Sightings sightings_;
  std::vector<planning::OtherUavTrack> tracks_;
  std::unordered_map<geometry::Index3, std::vector<std::uint16_t>, geometry::Index3Hash> hits_;  // offsets, by block
};

}  // namespace voxnav::pipeline
