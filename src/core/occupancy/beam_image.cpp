// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/beam_image.hpp"

#include <cstring>

#include "point_batch.hpp"
#include "voxnav/base/lanes.hpp"

namespace voxnav::occupancy {
namespace {

using namespace base::lanes;  // NOLINT: the vector types of this file

/// Where beams fall in the image, see BeamImage::project().
struct DrawnBatch {
  alignas(32) float range_sq[PointBatch::kSize];
  alignas(32) std::int32_t fine[PointBatch::kSize], coarse[PointBatch::kSize];
};

template <int Side, int Ratio>
VOXNAV_INLINE void draw(const PointBatch& batch, DrawnBatch* out) {
  constexpr float kHalf = 0.5f * Side;
  constexpr int kCoarse = Side / Ratio;
  const Floats first{}, last = first + static_cast<float>(Side - 1);
  for (std::size_t i = 0; i < PointBatch::kSize; i += kLanes) {
    const auto x = loaded<Floats>(batch.x + i), y = loaded<Floats>(batch.y + i), z = loaded<Floats>(batch.z + i);
    store(x * x + y * y + z * z, out->range_sq + i);
    const Ints is_y = absolute(y) > absolute(x);
    const Floats xy = is_y ? y : x;
    const Ints is_z = absolute(z) > absolute(xy);
    const Floats a = is_z ? z : xy;
    const Floats b = is_z ? x : is_y ? z : y, c = is_z ? y : is_y ? x : z;
    const Floats scale = kHalf / absolute(a);
    // In this order NaN becomes the first pixel.
    const Ints u = truncated(smaller(larger(b * scale + kHalf, first), last));
    const Ints v = truncated(smaller(larger(c * scale + kHalf, first), last));
    const Ints face = (is_z & 4) + (~is_z & is_y & 2) + ((a < 0.0f) & 1);
    store((face * Side + v) * Side + u, out->fine + i);
    store((face * kCoarse + v / Ratio) * kCoarse + u / Ratio, out->coarse + i);
  }
}

template <int Side, int Ratio>
VOXNAV_WIDE void draw_wide(const PointBatch& batch, DrawnBatch* out) {
  draw<Side, Ratio>(batch, out);
}

}  // namespace

void BeamImage::build(const float* points, std::size_t n, std::size_t stride, float nearest_m, float farthest_m,
                      bool use_farther) {
  points_ = points;
  stride_ = stride;
  farthest_m_ = farthest_m;
  is_first_kept_ = !is_first_kept_;
  constexpr int kCoarseSide = kSide / kRatio;
  fine_.resize(std::size_t{6} * kSide * kSide + kTogether);
  coarse_.resize(std::size_t{6} * kCoarseSide * kCoarseSide + kTogether);
  std::memset(fine_.data(), 0, fine_.size() * sizeof(Pixel));
  std::memset(coarse_.data(), 0, coarse_.size() * sizeof(Pixel));
  const float low = nearest_m * nearest_m;
  const float high = use_farther ? std::numeric_limits<float>::max() : farthest_m * farthest_m;
  PointBatch batch;
  DrawnBatch drawn;
  for (std::size_t begin = 0; begin < n; begin += PointBatch::kSize) {
    const std::size_t count = batch.load(points + begin * stride, n - begin, stride);
    (base::is_wide() ? draw_wide<kSide, kRatio> : draw<kSide, kRatio>)(batch, &drawn);
    for (std::size_t i = 0; i < count; ++i) {
      const float range_sq = drawn.range_sq[i];
      if (!(range_sq >= low && range_sq <= high)) continue;
      keep({static_cast<std::uint32_t>(begin + i), range_sq}, drawn.fine[i], drawn.coarse[i]);
    }
  }
}

/// Without branches, which nobody could predict: pixels are looked at as words, whose upper half is 0 where there is no
/// beam yet.
inline void BeamImage::keep(const Pixel& beam, std::int32_t fine, std::int32_t coarse) {
  const auto choose = [&beam](std::uint64_t takes, Pixel* kept) {
    std::uint64_t old, next;
    std::memcpy(&old, kept, sizeof old);
    std::memcpy(&next, &beam, sizeof next);
    old ^= (old ^ next) & takes;
    std::memcpy(kept, &old, sizeof old);
  };
  std::uint64_t first;
  std::memcpy(&first, &fine_[static_cast<std::size_t>(fine)], sizeof first);
  const std::uint64_t is_first = -static_cast<std::uint64_t>((first >> 32) == 0);
  choose(is_first, &coarse_[static_cast<std::size_t>(coarse)]);
  choose(is_first | -static_cast<std::uint64_t>(!is_first_kept_), &fine_[static_cast<std::size_t>(fine)]);
}

}  // namespace voxnav::occupancy
