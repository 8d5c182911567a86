// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "kernels/cube_map.hpp"
#include "kernels/seen_octants.hpp"

namespace voxnav::kernels {

/// The pixels of the beam image that each of eight balls touches: `height` rows of `width` pixels, `side` pixels apart.
/// Only pixels with a value of at least `least` count.
struct BeamPlaces {
  std::array<const BeamPixel*, lanes::kLanes> first;
  alignas(32) std::int32_t width[lanes::kLanes], height[lanes::kLanes];
  alignas(32) std::int32_t side[lanes::kLanes];
  alignas(32) BeamPixel least[lanes::kLanes];
};

constexpr float kHalfDiagonal = 0.8661f;  ///< half the diagonal of a voxel, rounded up, voxel edges
constexpr float kBallRadius = 0.6f;  ///< radius of the ball in which beams through a voxel are searched, voxel edges
constexpr int kMostFinePixels = 10;  ///< a ball wider than this many fine pixels is looked up in the coarse image

/// Computes the pixels of balls around x y z (frame L) [m]. Beams count if they are longer than `shortest_m`, up to one
/// range step of the image. A ball across an edge of the cube gets only the pixels of the face of its centre, and a
/// ball that contains the sensor or lies right beside it gets none.
VOXNAV_INLINE void find_places(const BeamImages& images, lanes::Floats x, lanes::Floats y, lanes::Floats z,
                               float radius_m, lanes::Floats shortest_m, BeamPlaces* out) {
  using namespace lanes;  // NOLINT: the vector types of this function
  constexpr float kHalf = 0.5f * kFineSide;
  const cube_map::Projection at = cube_map::project(x, y, z, kHalf);
  const Floats reach = radius_m * at.scale;
  const Ints is_outside = reach < kHalf / 1.5f;
  const Ints is_fine = reach <= 0.5f * kMostFinePixels;
  const auto in_image = [&](Floats coordinate) {
    const Ints fine = cube_map::pixel(coordinate, kFineSide);
    return is_fine ? fine : fine / kFineToCoarse;
  };
  const Ints u = in_image(at.u - reach), v = in_image(at.v - reach);
  const Ints side = is_fine ? Ints{} + kFineSide : Ints{} + kCoarseSide;
  alignas(32) std::int32_t first[kLanes], is_in_fine[kLanes];
  store((at.face * side + v) * side + u, first);
  store(is_fine, is_in_fine);
  store(in_image(at.u + reach) - u + 1, out->width);
  store((in_image(at.v + reach) - v + 1) & is_outside, out->height);
  store(side, out->side);
  const Floats most = Floats{} + static_cast<float>(kMaxBeamRange - 1);
  const Floats steps = smaller(larger(shortest_m, Floats{}) * images.steps_per_m, most);
  store((truncated(steps) + 1) << kBeamBits, out->least);
  for (std::size_t i = 0; i < kLanes; ++i) {
    out->first[i] = (is_in_fine[i] != 0 ? images.fine : images.coarse) + first[i];
  }
}

/// Returns a mask in which bit i is set if pixel i of kLanes in a row is at least `least`. All kLanes pixels are read,
/// also those behind the end of the row.
VOXNAV_INLINE unsigned reaching(const BeamPixel* pixels, BeamPixel least) {
#if defined(__SSE2__)
  const auto half = [&](const BeamPixel* from) {
    const __m128i in = _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
    return static_cast<unsigned>(_mm_movemask_ps(_mm_castsi128_ps(_mm_cmpgt_epi32(in, _mm_set1_epi32(least - 1)))));
  };
  return half(pixels) | half(pixels + 4) << 4;
#else
  unsigned bits = 0;
  for (int i = 0; i < lanes::kLanes; ++i) bits |= (pixels[i] >= least ? 1u : 0u) << i;
  return bits;
#endif
}

}  // namespace voxnav::kernels
