// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <mutex>

#include "pipeline/placed_obstacles.hpp"
#include "pipeline/placed_sightings.hpp"
#include "pipeline/terrain_map.hpp"
#include "planning/fences/fence_raster.hpp"
#include "voxnav/pipeline/navigation_map.hpp"

namespace voxnav::pipeline {

/// A snapshot of a NavigationMap, as the interface of planning.
class NavigationView : public planning::OccupancyView {
 public:
  struct Content {
    std::shared_ptr<const containers::StateGrid> local;   ///< frame O
    std::shared_ptr<const PlacedObstacles> obstacles;     ///< of the global map, may be null
    std::shared_ptr<const planning::FenceRaster> fences;  ///< may be null
    std::shared_ptr<const PlacedSightings> sightings;     ///< of the newest sweep, may be null
    std::shared_ptr<TerrainSource> terrain;               ///< of which the terrain under the map is asked, not null
    geometry::Pose T_W_O;
    geometry::Vec3 vehicle_O;
  };
  NavigationView(const NavigationMapConfig& config, Content content);

  double resolution_m() const override { return content_.local->resolution_m(); }
  containers::VoxelState state(const geometry::Index3& voxel) const override;
  geometry::Aabb bounds() const override { return bounds_; }
  const containers::StateBlock* block(const geometry::Index3& block, containers::StateBlock* scratch) const override;
  std::vector<geometry::Index3> known_blocks() const override;
  bool forbidden(const geometry::Index3& block, planning::BlockMask* hard, planning::BlockMask* soft) const override;
  std::shared_ptr<const planning::Fences> fences() const override;
  const planning::Sightings* sightings() const override;

 private:
  /// Takes the sides and the heights of the safety area into the limits.
  void limit_to_area(const planning::Prism& area);
  bool is_in_footprint(const geometry::Index3& voxel) const;
  geometry::Aabb box_of(const geometry::Index3& block) const;
  /// Appends the blocks within the bounds that touch a box.
  void add_blocks(const geometry::Aabb& box, std::vector<geometry::Index3>* out) const;
  void add_height_blocks(std::vector<geometry::Index3>* out) const;
  bool forbid_altitudes(const geometry::Index3& block, planning::BlockMask* hard) const;
  bool forbid_heights(const geometry::Index3& block, planning::BlockMask* hard) const;
  void allow_way_of_vehicle(const geometry::Index3& block, const TerrainColumn& there, planning::BlockMask* mask) const;
  /// The terrain under the map, which is found when it is first asked for: only plans need it.
  const TerrainMap& terrain() const;
  bool forbid_obstacles(const geometry::Index3& block, planning::BlockMask* mask) const;

  NavigationMapConfig config_;
  Content content_;
  HeightLimits heights_;
  double min_altitude_m_;  ///< limits in the map frame
  double max_altitude_m_;
  geometry::Aabb bounds_;
  geometry::Aabb footprint_;
  mutable std::once_flag terrain_once_;
  mutable std::shared_ptr<const TerrainMap> terrain_;
};

}  // namespace voxnav::pipeline
