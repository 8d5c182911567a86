// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "kernels/point_batch.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::kernels {

/// The transform of points of a scan to window coordinates, and its limits. Window coordinates are voxel edges from the
/// window's corner, in single precision, which resolves 10^-3 of a voxel up to 10^4 voxels.
struct PlacementFrame {
  Eigen::Matrix3f rotation;  ///< metres of frame L to voxel edges along the window's axes
  geometry::Vec3f origin;    ///< the sensor in window coordinates
  Eigen::Array3f low, high;  ///< limits between which ends of rays lie; never negative
  float nearest_m;
  float farthest_m;
};

/// The voxels of the points of a batch.
struct PlacedBatch {
  alignas(32) std::int32_t is_end[PointBatch::kSize];  ///< 0: the point is no hit inside the window
  alignas(32) std::int32_t voxel[3][PointBatch::kSize];
  alignas(32) float offset[3][PointBatch::kSize];  ///< offset from the centre of the voxel, voxel edges
};

/// Places all points of a batch; `voxel` and `offset` mean something only where `is_end` is not zero.
void place_points(const PointBatch& batch, const PlacementFrame& frame, PlacedBatch* out);

namespace reference {
void place_points(const PointBatch& batch, const PlacementFrame& frame, PlacedBatch* out);
}

}  // namespace voxnav::kernels
