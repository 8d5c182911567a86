// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

namespace voxnav::kernels {

/// The points of one scan in a voxel, and how much they count beside those of earlier scans.
struct MomentUpdate {
  std::array<float, 3> mean;        ///< from the centre of the voxel, voxel edges, within half an edge
  std::array<float, 6> covariance;  ///< xx xy xz yy yz zz, squared voxel edges
  float share;                      ///< of all points, 0 to 1
  float recent_share;               ///< of the points since the last handover
};

/// Mean and covariance of the points in a voxel in units that fit 16 bits. The two groups are read eight numbers at a
/// time, so two more must lie behind each of them; they are left alone.
struct StoredMoments {
  std::int16_t* covariance;  ///< xx xy xz yy yz zz; a squared voxel edge = kCovarianceUnits
  std::int16_t* means;       ///< x y z of all points, then x y z of the recent ones; half an edge = kMeanUnits
};
constexpr float kMeanUnits = 32000.0f;
constexpr float kCovarianceUnits = 120000.0f;  ///< points in a voxel spread by a quarter at most

/// Mixes new points into the moments: means move by their share, the covariance becomes that of a mixture of two sets
/// of points.
void blend_moments(const MomentUpdate& update, const StoredMoments& stored);

namespace reference {
void blend_moments(const MomentUpdate& update, const StoredMoments& stored);
}

}  // namespace voxnav::kernels
