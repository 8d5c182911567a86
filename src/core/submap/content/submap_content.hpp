// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <utility>

#include "submap/content/block_states.hpp"
#include "submap/content/measured_distances.hpp"
#include "submap/content/voxel_points.hpp"

namespace voxnav::submap {

/// The content of a finished submap: the states of its voxels, the surface points of the occupied ones, and the
/// distances near surfaces if they were measured by rays. Other distances follow from the surface points and are not
/// stored. Lengths are in voxel edges, frame G (the grid of the submap). Immutable, hence thread-safe.
class SubmapContent {
 public:
  SubmapContent() = default;
  /// @param band  distance from surfaces up to which distances are derived or kept, voxel edges
  SubmapContent(BlockStates states, VoxelPoints points, std::optional<MeasuredDistances> measured, double band)
      : states_(std::move(states)), points_(std::move(points)), measured_(std::move(measured)), band_(band) {}

  const BlockStates& states() const { return states_; }
  const VoxelPoints& points() const { return points_; }
  /// The measured distances, or null if there are none.
  const MeasuredDistances* measured() const { return measured_ ? &*measured_ : nullptr; }
  double band() const { return band_; }

  /// Calls f(voxel, number) for the occupied voxels of a block, with the occupancy::OccupiedVoxel and its number.
  template <class F>
  void for_each_voxel(std::size_t position, F&& f) const {
    if (!states_.has_occupied(position)) return;
    VoxelPoints::Reader reader(points_, states_.first_number(position));
    occupancy::OccupiedVoxel voxel;
    states_.for_each_occupied(position, [&](int offset, std::size_t number) {
      voxel.offset = static_cast<std::uint16_t>(offset);
      reader.next(&voxel);
      f(voxel, number);
    });
  }
  /// Calls f(index, voxel) for all occupied voxels, with the index of each in the grid.
  template <class F>
  void for_each_voxel(F&& f) const {
    for (std::size_t i = 0; i < states_.size(); ++i) {
      for_each_voxel(i, [&](const occupancy::OccupiedVoxel& voxel, std::size_t) {
        f(geometry::voxel_at(states_.index(i), voxel.offset), voxel);
      });
    }
  }

  /// Returns true if the submap observed anything in a block.
  bool is_observed(std::size_t position) const;
  /// Returns true if the submap holds anything that it did not observe but remembers from before it began.
  bool has_memory() const { return !points_.all_observed() || !states_.is_all_free_observed(); }
  /// Returns this content with other surface points. Measured distances would not fit them, so there may be none.
  void move_points(std::vector<occupancy::VoxelPoint> points) { points_.move_to(std::move(points)); }
  std::size_t memory_bytes() const;

 private:
  BlockStates states_;
  VoxelPoints points_;
  std::optional<MeasuredDistances> measured_;
  double band_ = 3.0;
};

/// Returns the position of a surface point in voxel edges.
inline geometry::Vec3 surface_point(const geometry::Index3& voxel, const occupancy::VoxelPoint& point) {
  return {voxel.x + 0.5 + point.mean[0] / 254.0, voxel.y + 0.5 + point.mean[1] / 254.0,
          voxel.z + 0.5 + point.mean[2] / 254.0};
}

/// Returns the content reduced to the surface that the submap observed: occupied voxels that it merely remembers become
/// unknown, the others hold the point of its own hits. Free voxels stay as they are. The result has no measured
/// distances. O(size).
SubmapContent observed_content(const SubmapContent& content);

}  // namespace voxnav::submap
