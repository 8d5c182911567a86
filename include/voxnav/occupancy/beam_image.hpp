// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
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
  /// the first or the last is kept, in turn from scan to scan.
  void build(const float* points, std::size_t n, std::size_t stride, float nearest_m, float farthest_m,
             bool use_farther);

  static constexpr int kTogether = 4;
  /// Some beams that lie in a row of pixels.
  struct Row {
    std::array<std::uint32_t, kTogether> points;  ///< their numbers
    unsigned reaching;                            ///< bit i: beam i is as long as was asked for
  };
  /// Calls visit(row) for all pixels that a ball touches until it returns true; beams count as reaching when they are
  /// at least `shortest` metres long. They are believed up to longest_m() only.
  template <class Visit>
  void for_beams_near(const geometry::Vec3f& center, float radius, float shortest, Visit visit) const;

  /// Its end, frame L: x y z [m].
  const float* end_of(std::uint32_t point) const { return points_ + point * stride_; }
  float longest_m() const { return farthest_m_; }
  std::size_t memory_bytes() const { return (fine_.capacity() + coarse_.capacity()) * sizeof(Pixel); }

 private:
  static constexpr int kSide = 192;          ///< pixels of one face: 0.6 degrees in its middle
  static constexpr int kRatio = 4;           ///< fine pixels to a coarse one
  static constexpr int kMaxFinePixels = 10;  ///< across what is looked at; beyond it the coarse image serves

  struct Pixel {
    std::uint32_t point;
    float range_sq;  ///< of ordinary size or larger; 0 = no beam
  };
  static_assert(sizeof(Pixel) == sizeof(std::uint64_t), "read and written as one word");
  void keep(const Pixel& beam, std::int32_t fine, std::int32_t coarse);
  /// Bit i: the beam of pixel i, of kTogether in a row, is at least so long.
  static unsigned reaching(const Pixel* pixels, float least_sq) {
#if defined(__SSE2__)
    const auto* in = reinterpret_cast<const float*>(pixels);
    const __m128 ranges = _mm_shuffle_ps(_mm_loadu_ps(in), _mm_loadu_ps(in + 4), _MM_SHUFFLE(3, 1, 3, 1));
    return static_cast<unsigned>(_mm_movemask_ps(_mm_cmpge_ps(ranges, _mm_set1_ps(least_sq))));
#else
    unsigned bits = 0;
    for (int i = 0; i < kTogether; ++i) bits |= (pixels[i].range_sq >= least_sq ? 1u : 0u) << i;
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
  bool is_first_kept_ = false;
  std::vector<Pixel> fine_, coarse_;
};

template <class Visit>
void BeamImage::for_beams_near(const geometry::Vec3f& center, float radius, float shortest, Visit visit) const {
  const Projection at = project(center);
  if (!(at.depth > 1.5f * radius)) return;  // the sensor is in or beside it
  const float reach = radius * 0.5f * kSide / at.depth;
  const bool is_fine = 2.0f * reach <= kMaxFinePixels;
  const int ratio = is_fine ? 1 : kRatio, side = kSide / ratio;
  const int u_low = pixel(at.u - reach) / ratio, u_high = pixel(at.u + reach) / ratio;
  const int v_low = pixel(at.v - reach) / ratio, v_high = pixel(at.v + reach) / ratio;
  const Pixel* face = (is_fine ? fine_ : coarse_).data() + at.face * side * side;
  const float least_sq = std::max(shortest * shortest, std::numeric_limits<float>::min());
  for (int v = v_low; v <= v_high; ++v) {
    for (int u = u_low; u <= u_high; u += kTogether) {
      const Pixel* pixels = face + v * side + u;
      const unsigned inside = (2u << std::min(u_high - u, kTogether - 1)) - 1u;
      if (visit(Row{{pixels[0].point, pixels[1].point, pixels[2].point, pixels[3].point},
                    reaching(pixels, least_sq) & inside})) {
        return;
      }
    }
  }
}

}  // namespace voxnav::occupancy
