// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "kernels/point_batch.hpp"

namespace voxnav::kernels {

/// A pixel of the images into which beams of a scan are drawn. Its lower bits hold the number of a beam, the upper ones
/// the range of the beam in steps, rounded up; 0 = no beam. A pixel is small, so that an image fits the cache, and
/// never negative, so that signed comparisons order by range.
using BeamPixel = std::int32_t;
constexpr int kBeamBits = 20;
constexpr BeamPixel kBeamMask = (1 << kBeamBits) - 1;
constexpr int kMaxBeamRange = (1 << (31 - kBeamBits)) - 1;  ///< steps

/// Sides of the six faces of the two images (cube_map.hpp): a fine pixel is 0.6 degrees in the middle of a face.
constexpr int kFineSide = 192;
constexpr int kFineToCoarse = 4;  ///< fine pixels along each side of a coarse one
constexpr int kCoarseSide = kFineSide / kFineToCoarse;

/// The limits of the squared range [m^2] between which beams are drawn, and the resolution of ranges.
struct DrawnRanges {
  float low_sq, high_sq;
  float steps_per_m;
};

/// The pixels of the beams of a batch.
struct DrawnBatch {
  alignas(32) std::int32_t range[PointBatch::kSize];  ///< steps, rounded up; 0 = the beam is not drawn
  alignas(32) std::int32_t fine[PointBatch::kSize], coarse[PointBatch::kSize];  ///< numbers of pixels
};

void draw_beams(const PointBatch& batch, const DrawnRanges& ranges, DrawnBatch* out);

namespace reference {
void draw_beams(const PointBatch& batch, const DrawnRanges& ranges, DrawnBatch* out);
}

}  // namespace voxnav::kernels
