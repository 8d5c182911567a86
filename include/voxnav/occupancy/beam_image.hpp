// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "voxnav/geometry/pose.hpp"
#include "voxnav/occupancy/byte_ops.hpp"

namespace voxnav::occupancy {

/// The beams of one scan by direction, so that those through a given voxel are found without looking at all: six
/// square images around the sensor (a cube map), each pixel with one of the beams that fall into it, and the same at a
/// quarter of the resolution for what is near. Frame L.
class BeamImage {
 public:
  /// Takes beams with ranges between nearest_m and farthest_m; those that went farther count as farthest_m long, or
  /// are left out. The points must stay where they are as long as beams are looked up. Of several beams in a pixel
  /// the first or the last is kept, in turn from scan to scan. Of more than 2^20 points only every second, third, ...
  /// is taken.
  void build(const float* points, std::size_t n, std::size_t stride, float nearest_m, float farthest_m,
             bool use_farther);

  static constexpr int kTogether = 8;
  /// Calls visit(beams, reaching) for rows of pixels that a ball touches until it returns true: bit i of `reaching` is
  /// set when beam i of the kTogether in the row is longer than `shortest` metres, to a step of the image's ranges.
  /// Beams are believed up to longest_m() only.
  template <class Visit>
  VOXNAV_INLINE void for_beams_near(const geometry::Vec3f& center, float radius, float shortest, Visit visit) const;

  /// Its end, frame L: x y z [m].
  const float* end_of(std::uint32_t beam) const { return points_ + beam * stride_; }
  float longest_m() const { return farthest_m_; }
  std::size_t memory_bytes() const { return (fine_.capacity() + coarse_.capacity()) * sizeof(Pixel); }

  /// The number of a beam, and above it its range in steps, rounded up; 0 = no beam. Small, so that the image fits the
  /// cache, and never negative, so that signed comparisons order by range.
  using Pixel = std::int32_t;
  static constexpr int kBeamBits = 20;
  static constexpr Pixel kBeamMask = (1 << kBeamBits) - 1;
  static constexpr int kMaxRange = (1 << (31 - kBeamBits)) - 1;

 private:
  static constexpr int kSide = 192;          ///< pixels of one face: 0.6 degrees in its middle
  static constexpr int kRatio = 4;           ///< fine pixels to a coarse one
  static constexpr int kMaxFinePixels = 10;  ///< across what is looked at; beyond it the coarse image serves

  void keep(Pixel beam, std::int32_t fine, std::int32_t coarse);
  /// Bit i: the beam of pixel i, of kTogether in a row, is at least as far as `least` is.
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
  struct Projection {
    int face;
    float u, v;  ///< fine pixels
    float depth;
  };
  static Projection project(const geometry::Vec3f& p) {
    int a = std::abs(p.x()) >= std::abs(p.y()) ? 0 : 1;
    if (std::abs(p.z()) > std::abs(p[a])) a = 2;
    const int b = a == 2 ? 0 : a + 1, c = b == 2 ? 0 : b + 1;
    const float depth = std::abs(p[a]);
    const float scale = 0.5f * kSide / depth;
    return {2 * a + (p[a] < 0.0f ? 1 : 0), p[b] * scale + 0.5f * kSide, p[c] * scale + 0.5f * kSide, depth};
  }
  static int pixel(float coordinate) { return std::min(kSide - 1, std::max(0, static_cast<int>(coordinate))); }

  const float* points_ = nullptr;
  std::size_t stride_ = 3;
  float farthest_m_ = 0.0f;
  float steps_per_m_ = 0.0f;  ///< of ranges in the image
  bool is_first_kept_ = false;
  std::vector<Pixel> fine_, coarse_;
};

template <class Visit>
VOXNAV_INLINE void BeamImage::for_beams_near(const geometry::Vec3f& center, float radius, float shortest,
                                             Visit visit) const {
  const Projection at = project(center);
  if (!(at.depth > 1.5f * radius)) return;  // the sensor is in or beside it
  const float reach = radius * 0.5f * kSide / at.depth;
  const bool is_fine = 2.0f * reach <= kMaxFinePixels;
  const int ratio = is_fine ? 1 : kRatio, side = kSide / ratio;
  const int u_low = pixel(at.u - reach) / ratio, u_high = pixel(at.u + reach) / ratio;
  const int v_low = pixel(at.v - reach) / ratio, v_high = pixel(at.v + reach) / ratio;
  const Pixel* face = (is_fine ? fine_ : coarse_).data() + at.face * side * side;
  const float least_range = std::max(shortest, 0.0f) * steps_per_m_;
  const Pixel least = (1 + static_cast<Pixel>(std::min(least_range, kMaxRange - 1.0f))) << kBeamBits;
  for (int v = v_low; v <= v_high; ++v) {
    for (int u = u_low; u <= u_high; u += kTogether) {
      const Pixel* pixels = face + v * side + u;
      const unsigned inside = (2u << std::min(u_high - u, kTogether - 1)) - 1u;
      if (visit(pixels, reaching(pixels, least) & inside)) return;
    }
  }
}

}  // namespace voxnav::occupancy
