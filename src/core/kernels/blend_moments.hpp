// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

namespace voxnav::kernels {

/// Moments of the points of one scan in a voxel, with their weights beside the points of earlier scans.
struct MomentUpdate {
  std::array<float, 3> mean;        ///< from the centre of the voxel, voxel edges, within half an edge
  std::array<float, 6> covariance;  ///< xx xy xz yy yz zz, squared voxel edges
  float share;                      ///< weight among all scans, 0 to 1
  float recent_share;               ///< weight among the scans since the last handover, 0 to 1
};

/// Mean and covariance of the points in a voxel, in units that fit 16 bits. Both arrays are read and written eight
/// numbers at a time, so two more numbers must follow each of them; these keep their values.
struct StoredMoments {
  std::int16_t* covariance;  ///< xx xy xz yy yz zz; a squared voxel edge = kCovarianceUnits
  std::int16_t* means;       ///< x y z of all points, then x y z of the recent ones; half an edge = kMeanUnits
};
constexpr float kMeanUnits = 32000.0f;
constexpr float kCovarianceUnits = 120000.0f;  ///< units of a squared edge; covariances are at most a quarter of one

/// Updates the moments with new points: the means move by the weight of the new points, and the covariance becomes that
/// of the mixture of both sets of points (docs/maths/occupancy.md, section The surface inside a voxel).
void blend_moments(const MomentUpdate& update, const StoredMoments& stored);

namespace reference {
void blend_moments(const MomentUpdate& update, const StoredMoments& stored);
}

}  // namespace voxnav::kernels
