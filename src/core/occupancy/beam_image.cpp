// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/beam_image.hpp"

#include <limits>

namespace voxnav::occupancy {

using kernels::BeamPixel;
using kernels::PointBatch;

void BeamImage::build(const float* points, std::size_t n, std::size_t stride, float nearest_m, float farthest_m,
                      bool use_farther) {
  const std::size_t every = 1 + (n >> kernels::kBeamBits);
  n = (n + every - 1) / every;
  points_ = points;
  stride_ = stride * every;
  farthest_m_ = farthest_m;
  // All beams of the maximum range and beyond share the last range step: nothing asks how much longer one of them is.
  steps_per_m_ = static_cast<float>(kernels::kMaxBeamRange - 1) / farthest_m;
  is_first_kept_ = !is_first_kept_;
  const auto clear = [](std::size_t side, std::vector<BeamPixel>* image) {
    image->assign(6 * side * side + kernels::lanes::kLanes, 0);
  };
  clear(kernels::kFineSide, &fine_);
  clear(kernels::kCoarseSide, &coarse_);
  const kernels::DrawnRanges ranges{
      nearest_m * nearest_m, use_farther ? std::numeric_limits<float>::max() : farthest_m * farthest_m, steps_per_m_};
  PointBatch batch;
  kernels::DrawnBatch drawn;
  for (std::size_t begin = 0; begin < n; begin += PointBatch::kSize) {
    const std::size_t count = batch.load(points + begin * stride_, n - begin, stride_);
    kernels::draw_beams(batch, ranges, &drawn);
    for (std::size_t i = 0; i < count; ++i) {
      if (drawn.range[i] == 0) continue;
      keep(drawn.range[i] << kernels::kBeamBits | static_cast<BeamPixel>(begin + i), drawn.fine[i], drawn.coarse[i]);
    }
  }
}

/// Selects by masks instead of branches: whether a pixel is empty changes from beam to beam, so a processor would
/// mispredict a branch here often.
inline void BeamImage::keep(BeamPixel beam, std::int32_t fine, std::int32_t coarse) {
  BeamPixel& fine_pixel = fine_[static_cast<std::size_t>(fine)];
  BeamPixel& coarse_pixel = coarse_[static_cast<std::size_t>(coarse)];
  const BeamPixel is_first = -static_cast<BeamPixel>(fine_pixel == 0);
  const auto choose = [beam](BeamPixel takes, BeamPixel old) { return old ^ ((old ^ beam) & takes); };
  coarse_pixel = choose(is_first, coarse_pixel);
  fine_pixel = choose(is_first | -static_cast<BeamPixel>(!is_first_kept_), fine_pixel);
}

}  // namespace voxnav::occupancy
