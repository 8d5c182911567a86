// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "voxnav/geometry/pose.hpp"

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

  /// Calls visit(end of the beam, its squared distance [m^2]) for beams of at least `shortest` metres in pixels that a
  /// ball touches, until it returns true. Beams are no longer than longest_m().
  template <class Visit>
  void for_beams_near(const geometry::Vec3f& center, float radius, float shortest, Visit visit) const;

  float longest_m() const { return farthest_m_; }
  std::size_t memory_bytes() const { return (fine_.capacity() + coarse_.capacity()) * sizeof(Pixel); }

 private:
  static constexpr int kSide = 192;          ///< pixels of one face: 0.6 degrees in its middle
  static constexpr int kRatio = 4;           ///< fine pixels to a coarse one
  static constexpr int kMaxFinePixels = 10;  ///< across what is looked at; beyond it the coarse image serves

  struct Pixel {
    std::uint32_t point;
    float range_sq;  ///< 0 = no beam
  };
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
    for (int u = u_low; u <= u_high; ++u) {
      const Pixel& beam = face[v * side + u];
      if (beam.range_sq < least_sq) continue;
      const float* p = points_ + beam.point * stride_;
      if (visit(geometry::Vec3f(p[0], p[1], p[2]), beam.range_sq)) return;
    }
  }
}

}  // namespace voxnav::occupancy
