// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/beam_image.hpp"

namespace voxnav::occupancy {

void BeamImage::build(const float* points, std::size_t n, std::size_t stride, float nearest_m, float farthest_m,
                      bool use_farther) {
  points_ = points;
  stride_ = stride;
  farthest_m_ = farthest_m;
  is_first_kept_ = !is_first_kept_;
  constexpr int kCoarseSide = kSide / kRatio;
  fine_.assign(std::size_t{6} * kSide * kSide, Pixel{0, 0.0f});
  coarse_.assign(std::size_t{6} * kCoarseSide * kCoarseSide, Pixel{0, 0.0f});
  const float low = nearest_m * nearest_m;
  const float high = use_farther ? std::numeric_limits<float>::max() : farthest_m * farthest_m;
  for (std::size_t i = 0; i < n; ++i) {
    const float* p = points + i * stride;
    const geometry::Vec3f end(p[0], p[1], p[2]);
    const float range_sq = end.squaredNorm();
    if (!(range_sq >= low && range_sq <= high)) continue;
    const Projection at = project(end);
    const int u = pixel(at.u), v = pixel(at.v);
    Pixel& kept = fine_[(at.face * kSide + v) * kSide + u];
    const Pixel beam{static_cast<std::uint32_t>(i), range_sq};
    if (kept.range_sq == 0.0f) {
      kept = beam;
      coarse_[(at.face * kCoarseSide + v / kRatio) * kCoarseSide + u / kRatio] = beam;
    } else if (!is_first_kept_) {
      kept = beam;
    }
  }
}

}  // namespace voxnav::occupancy
