// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernels/draw_beams.hpp"
#include "kernels/lanes.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::kernels {

/// The beams of a scan in the two images into which draw_beams() draws them. Rows are read kLanes pixels at a time, so
/// kLanes more pixels follow the last one.
struct BeamImages {
  const BeamPixel* fine;
  const BeamPixel* coarse;
  const float* ends;   ///< frame L [m]; x y z of beam i from ends[i * stride] on
  std::size_t stride;  ///< floats from one beam to the next
  float steps_per_m;   ///< range steps of a pixel per metre
};

/// The rules by which a beam saw through the surface in a voxel. Lengths are voxel edges unless they end in _m.
struct SightRules {
  Eigen::Matrix3f to_window;  ///< metres of frame L to voxel edges along the window's axes
  Eigen::Matrix3f to_frame_L;
  float resolution_m;
  float longest;  ///< length at which longer beams are cut
  float behind;   ///< minimum length of a beam behind the hits in the voxel
  float sigmas;   ///< a beam passes where the hits are if it comes within this many standard deviations of them
  float spread;   ///< added to these standard deviations
};

/// A batch of up to eight voxels of a block. Lanes that would be empty repeat the first voxel.
struct AskedVoxels {
  int size;
  alignas(32) std::int32_t offsets[lanes::kLanes];  ///< offset in the block, x + 16 y + 256 z
  /// Mean (x y z) and covariance (xx xy xz yy yz zz) of the hits in each voxel, as in blend_moments.hpp.
  const std::int16_t* means[lanes::kLanes];
  const std::int16_t* covariances[lanes::kLanes];
};

/// Returns the octants of each voxel through which beams passed that end far enough behind it; all eight octants if one
/// such beam passed where the hits are. Lengths are compared by their squares, so only one square root is needed, to a
/// thousandth.
/// @param first_center  centre of the block's first voxel, from the sensor along the window's axes, voxel edges
void seen_octants(const BeamImages& images, const SightRules& rules, const geometry::Vec3f& first_center,
                  const AskedVoxels& asked, std::int32_t* octants);

namespace reference {
/// Computes the same voxel by voxel and beam by beam: the scalar reference.
void seen_octants(const BeamImages& images, const SightRules& rules, const geometry::Vec3f& first_center,
                  const AskedVoxels& asked, std::int32_t* octants);
}  // namespace reference

}  // namespace voxnav::kernels
