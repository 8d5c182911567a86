// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "occupancy/cube_map.hpp"

namespace voxnav::occupancy {

/// The beams of one scan by direction, so that those through a given voxel are found without looking at all: six
/// square images around the sensor (a cube map), each pixel with one of the beams that fall into it, and the same at a
/// quarter of the resolution for what is near. Frame L.
class BeamImage {
 public:
  /// The number of a beam, and above it its range in steps, rounded up; 0 = no beam. Small, so that the image fits the
  /// cache, and never negative, so that signed comparisons order by range.
  using Pixel = std::int32_t;
  static constexpr int kBeamBits = 20;
  static constexpr Pixel kBeamMask = (1 << kBeamBits) - 1;
  static constexpr int kMaxRange = (1 << (31 - kBeamBits)) - 1;

  /// Takes beams with ranges between nearest_m and farthest_m; those that went farther count as farthest_m long, or
  /// are left out. The points must stay where they are as long as beams are looked up. Of several beams in a pixel
  /// the first or the last is kept, in turn from scan to scan. Of more than 2^20 points only every second, third, ...
  /// is taken.
  void build(const float* points, std::size_t n, std::size_t stride, float nearest_m, float farthest_m,
             bool use_farther);

  /// The pixels that each of eight balls touches: rows of `width`, `height` of them, `side` apart. What counts there
  /// are pixels of at least `least`.
  struct Places {
    std::array<const Pixel*, base::lanes::kLanes> first;
    alignas(32) std::int32_t width[base::lanes::kLanes], height[base::lanes::kLanes];
    alignas(32) std::int32_t side[base::lanes::kLanes];
    alignas(32) Pixel least[base::lanes::kLanes];
  };
  /// Balls around x y z (frame L); beams count when they are longer than `shortest` metres, to a step of the image's
  /// ranges. A ball across an edge of the cube has only the pixels of the face that its centre is on, and nothing is
  /// touched by a ball that the sensor is in or beside. Beams are believed up to longest_m() only.
  VOXNAV_INLINE void find(base::lanes::Floats x, base::lanes::Floats y, base::lanes::Floats z, float radius,
                          base::lanes::Floats shortest, Places* out) const;
  static constexpr int kTogether = base::lanes::kLanes;
  /// Bit i: pixel i, of kTogether in a row, is at least `least`. Reads all of them, which may lie behind the row.
  static VOXNAV_INLINE unsigned reaching(const Pixel* pixels, Pixel least) {
#if defined(__SSE2__)
    const auto half = [&](const Pixel* from) {
      const __m128i in = _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
      return static_cast<unsigned>(_mm_movemask_ps(_mm_castsi128_ps(_mm_cmpgt_epi32(in, _mm_set1_epi32(least - 1)))));
    };
    return half(pixels) | half(pixels + 4) << 4;
#else
    unsigned bits = 0;
    for (int i = 0; i < kTogether; ++i) bits |= (pixels[i] >= least ? 1u : 0u) << i;
    return bits;
#endif
  }

  /// Its end, frame L: x y z [m].
  const float* end_of(std::uint32_t beam) const { return points_ + beam * stride_; }
  float longest_m() const { return farthest_m_; }
  std::size_t memory_bytes() const { return (fine_.capacity() + coarse_.capacity()) * sizeof(Pixel); }

 private:
  static constexpr int kSide = 192;          ///< pixels of one face: 0.6 degrees in its middle
  static constexpr int kRatio = 4;           ///< fine pixels to a coarse one
  static constexpr int kMaxFinePixels = 10;  ///< across what is looked at; beyond it the coarse image serves

  void keep(Pixel beam, std::int32_t fine, std::int32_t coarse);

  const float* points_ = nullptr;
  std::size_t stride_ = 3;
  float farthest_m_ = 0.0f;
  float steps_per_m_ = 0.0f;  ///< of ranges in the image
  bool is_first_kept_ = false;
  std::vector<Pixel> fine_, coarse_;
};

VOXNAV_INLINE void BeamImage::find(base::lanes::Floats x, base::lanes::Floats y, base::lanes::Floats z, float radius,
                                   base::lanes::Floats shortest, Places* out) const {
  using namespace base::lanes;  // NOLINT: the vector types of this function
  constexpr float kHalf = 0.5f * kSide;
  constexpr int kCoarseSide = kSide / kRatio;
  const cube_map::Projection at = cube_map::project(x, y, z, kHalf);
  const Floats reach = radius * at.scale;
  const Ints is_outside = reach < kHalf / 1.5f;
  const Ints is_fine = reach <= 0.5f * kMaxFinePixels;
  const auto in_image = [&](Floats coordinate) {
    const Ints fine = cube_map::pixel(coordinate, kSide);
    return is_fine ? fine : fine / kRatio;
  };
  const Ints u = in_image(at.u - reach), v = in_image(at.v - reach);
  const Ints side = is_fine ? Ints{} + kSide : Ints{} + kCoarseSide;
  alignas(32) std::int32_t first[kLanes], is_in_fine[kLanes];
  store((at.face * side + v) * side + u, first);
  store(is_fine, is_in_fine);
  store(in_image(at.u + reach) - u + 1, out->width);
  store((in_image(at.v + reach) - v + 1) & is_outside, out->height);
  store(side, out->side);
  const Floats steps = smaller(larger(shortest, Floats{}) * steps_per_m_, Floats{} + static_cast<float>(kMaxRange - 1));
  store((truncated(steps) + 1) << kBeamBits, out->least);
  for (std::size_t i = 0; i < kLanes; ++i) out->first[i] = (is_in_fine[i] != 0 ? fine_ : coarse_).data() + first[i];
}

}  // namespace voxnav::occupancy
