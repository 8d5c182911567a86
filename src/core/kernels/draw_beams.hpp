// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "kernels/point_batch.hpp"

namespace voxnav::kernels {

/// A pixel of the images that beams of a scan are drawn into: the number of a beam, and above it its range in steps,
/// rounded up; 0 = no beam. It is small, so that an image fits the cache, and never negative, so that signed
/// comparisons order by range.
using BeamPixel = std::int32_t;
constexpr int kBeamBits = 20;
constexpr BeamPixel kBeamMask = (1 << kBeamBits) - 1;
constexpr int kMaxBeamRange = (1 << (31 - kBeamBits)) - 1;  ///< steps

/// Sides of the six faces of the two images (cube_map.hpp): a fine pixel is 0.6 degrees in the middle of a face.
constexpr int kFineSide = 192;
constexpr int kFineToCoarse = 4;  ///< fine pixels to a coarse one, along each side
constexpr int kCoarseSide = kFineSide / kFineToCoarse;

/// Which beams are drawn, by the square of their range [m^2], and how long a step of range is.
struct DrawnRanges {
  float low_sq, high_sq;
  float steps_per_m;
};

/// Where the beams of a batch fall.
struct DrawnBatch {
  alignas(32) std::int32_t range[PointBatch::kSize];  ///< steps, rounded up; 0 = the beam is not drawn
  alignas(32) std::int32_t fine[PointBatch::kSize], coarse[PointBatch::kSize];  ///< numbers of pixels
};

void draw_beams(const PointBatch& batch, const DrawnRanges& ranges, DrawnBatch* out);

namespace reference {
void draw_beams(const PointBatch& batch, const DrawnRanges& ranges, DrawnBatch* out);
}

}  // namespace voxnav::kernels
