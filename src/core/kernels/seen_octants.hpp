// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernels/draw_beams.hpp"
#include "kernels/lanes.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::kernels {

/// The beams of a scan in the two images that draw_beams() places them in. Rows are read kLanes pixels at a time, so
/// so many more lie behind the last one.
struct BeamImages {
  const BeamPixel* fine;
  const BeamPixel* coarse;
  const float* ends;   ///< frame L [m]; x y z of beam i from ends[i * stride] on
  std::size_t stride;  ///< floats
  float steps_per_m;   ///< of ranges in the pixels
};

/// When a beam saw through what is in a voxel. Lengths are voxel edges unless they end in _m.
struct SightRules {
  Eigen::Matrix3f to_window;  ///< metres of frame L to voxel edges along the window's axes
  Eigen::Matrix3f to_frame_L;
  float resolution_m;
  float longest;  ///< beams are believed up to this length
  float behind;   ///< a beam has to go on so far behind the hits in the voxel
  float sigmas;   ///< it meets the hits when it passes within so many of their standard deviations
  float spread;   ///< is added to these deviations
};

/// Up to eight voxels of a block that are asked together. Lanes that would be empty repeat the first voxel.
struct AskedVoxels {
  int size;
  alignas(32) std::int32_t offsets[lanes::kLanes];  ///< in the block: x + 16 y + 256 z
  /// Mean (x y z) and covariance (xx xy xz yy yz zz) of the hits in each voxel, as in blend_moments.hpp.
  const std::int16_t* means[lanes::kLanes];
  const std::int16_t* covariances[lanes::kLanes];
};

/// Octants of each voxel that beams went through with nothing behind that stopped them; all eight when one of them went
/// on behind the hits where the hits were. Lengths are compared by their squares, so no root is taken but one, and that
/// to a thousandth.
/// @param first_center  of the block's first voxel, from the sensor along the window's axes, voxel edges
void seen_octants(const BeamImages& images, const SightRules& rules, const geometry::Vec3f& first_center,
                  const AskedVoxels& asked, std::int32_t* octants);

namespace reference {
/// The same, voxel by voxel and beam by beam.
void seen_octants(const BeamImages& images, const SightRules& rules, const geometry::Vec3f& first_center,
                  const AskedVoxels& asked, std::int32_t* octants);
}  // namespace reference

}  // namespace voxnav::kernels
