// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/beam_image.hpp"

#include <limits>

#include "base/lanes.hpp"
#include "point_batch.hpp"

namespace voxnav::occupancy {
namespace {

using namespace base::lanes;  // NOLINT: the vector types of this file

/// Where beams fall in the image, see cube_map.
struct DrawnBatch {
  alignas(32) std::int32_t range[PointBatch::kSize];  ///< steps, rounded up; 0 = not to be drawn
  alignas(32) std::int32_t fine[PointBatch::kSize], coarse[PointBatch::kSize];
};

struct Ranges {
  float low_sq, high_sq;
  float steps_per_m;
};

template <int Side, int Ratio>
VOXNAV_INLINE void draw(const PointBatch& batch, const Ranges& ranges, DrawnBatch* out) {
  constexpr int kCoarse = Side / Ratio;
  const Floats zero{}, farthest = zero + static_cast<float>(BeamImage::kMaxRange - 1);
  for (std::size_t i = 0; i < PointBatch::kSize; i += kLanes) {
    const auto x = loaded<Floats>(batch.x + i), y = loaded<Floats>(batch.y + i), z = loaded<Floats>(batch.z + i);
    const Floats range_sq = x * x + y * y + z * z;
    const Ints is_drawn = (range_sq >= ranges.low_sq) & (range_sq <= ranges.high_sq);  // comparisons that NaN fails
    const Floats steps = smaller(exact_root(is_drawn ? range_sq : zero) * ranges.steps_per_m, farthest);
    store((1 + truncated(steps)) & is_drawn, out->range + i);
    const cube_map::Projection at = cube_map::project(x, y, z, 0.5f * Side);
    const Ints u = cube_map::pixel(at.u, Side), v = cube_map::pixel(at.v, Side);
    store((at.face * Side + v) * Side + u, out->fine + i);
    store((at.face * kCoarse + v / Ratio) * kCoarse + u / Ratio, out->coarse + i);
  }
}

template <int Side, int Ratio>
VOXNAV_WIDE void draw_wide(const PointBatch& batch, const Ranges& ranges, DrawnBatch* out) {
  draw<Side, Ratio>(batch, ranges, out);
}

}  // namespace

void BeamImage::build(const float* points, std::size_t n, std::size_t stride, float nearest_m, float farthest_m,
                      bool use_farther) {
  const std::size_t every = 1 + (n >> kBeamBits);
  n = (n + every - 1) / every;
  points_ = points;
  stride_ = stride * every;
  farthest_m_ = farthest_m;
  // Longest ones need not be told apart.
  steps_per_m_ = static_cast<float>(kMaxRange - 1) / farthest_m;
  is_first_kept_ = !is_first_kept_;
  constexpr int kCoarseSide = kSide / kRatio;
  fine_.assign(std::size_t{6} * kSide * kSide + kTogether, 0);
  coarse_.assign(std::size_t{6} * kCoarseSide * kCoarseSide + kTogether, 0);
  const Ranges ranges{nearest_m * nearest_m, use_farther ? std::numeric_limits<float>::max() : farthest_m * farthest_m,
                      steps_per_m_};
  PointBatch batch;
  DrawnBatch drawn;
  for (std::size_t begin = 0; begin < n; begin += PointBatch::kSize) {
    const std::size_t count = batch.load(points + begin * stride_, n - begin, stride_);
    (base::is_wide() ? draw_wide<kSide, kRatio> : draw<kSide, kRatio>)(batch, ranges, &drawn);
    for (std::size_t i = 0; i < count; ++i) {
      if (drawn.range[i] == 0) continue;
      keep(drawn.range[i] << kBeamBits | static_cast<Pixel>(begin + i), drawn.fine[i], drawn.coarse[i]);
    }
  }
}

/// Without branches, which nobody could predict.
inline void BeamImage::keep(Pixel beam, std::int32_t fine, std::int32_t coarse) {
  Pixel& fine_pixel = fine_[static_cast<std::size_t>(fine)];
  Pixel& coarse_pixel = coarse_[static_cast<std::size_t>(coarse)];
  const Pixel is_first = -static_cast<Pixel>(fine_pixel == 0);
  const auto choose = [beam](Pixel takes, Pixel old) { return old ^ ((old ^ beam) & takes); };
  coarse_pixel = choose(is_first, coarse_pixel);
  fine_pixel = choose(is_first | -static_cast<Pixel>(!is_first_kept_), fine_pixel);
}

}  // namespace voxnav::occupancy
