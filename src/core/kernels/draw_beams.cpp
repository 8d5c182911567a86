// SPDX-License-Identifier: BSD-3-Clause
#include "kernels/draw_beams.hpp"

#include "kernels/cube_map.hpp"

namespace voxnav::kernels {
namespace {

using namespace lanes;  // NOLINT: the vector types of this file

VOXNAV_INLINE void draw(const PointBatch& batch, const DrawnRanges& ranges, DrawnBatch* out) {
  const Floats zero{}, farthest = zero + static_cast<float>(kMaxBeamRange - 1);
  for (std::size_t i = 0; i < PointBatch::kSize; i += kLanes) {
    const auto x = loaded<Floats>(batch.x + i), y = loaded<Floats>(batch.y + i), z = loaded<Floats>(batch.z + i);
    const Floats range_sq = x * x + y * y + z * z;
    const Ints is_drawn = (range_sq >= ranges.low_sq) & (range_sq <= ranges.high_sq);  // NaN fails both comparisons
    const Floats steps = smaller(exact_root(is_drawn ? range_sq : zero) * ranges.steps_per_m, farthest);
    store((1 + truncated(steps)) & is_drawn, out->range + i);
    const cube_map::Projection at = cube_map::project(x, y, z, 0.5f * kFineSide);
    const Ints u = cube_map::pixel(at.u, kFineSide), v = cube_map::pixel(at.v, kFineSide);
    store((at.face * kFineSide + v) * kFineSide + u, out->fine + i);
    store((at.face * kCoarseSide + v / kFineToCoarse) * kCoarseSide + u / kFineToCoarse, out->coarse + i);
  }
}
void draw_plain(const PointBatch& batch, const DrawnRanges& ranges, DrawnBatch* out) { draw(batch, ranges, out); }
VOXNAV_WIDE void draw_wide(const PointBatch& batch, const DrawnRanges& ranges, DrawnBatch* out) {
  draw(batch, ranges, out);
}

}  // namespace

void draw_beams(const PointBatch& batch, const DrawnRanges& ranges, DrawnBatch* out) {
  (is_wide() ? draw_wide : draw_plain)(batch, ranges, out);
}

void reference::draw_beams(const PointBatch& batch, const DrawnRanges& ranges, DrawnBatch* out) {
  const auto farthest = static_cast<float>(kMaxBeamRange - 1);
  for (std::size_t i = 0; i < PointBatch::kSize; ++i) {
    const float x = batch.x[i], y = batch.y[i], z = batch.z[i];
    const float range_sq = x * x + y * y + z * z;
    const bool is_drawn = range_sq >= ranges.low_sq && range_sq <= ranges.high_sq;
    out->range[i] = 0;
    if (is_drawn) out->range[i] = 1 + static_cast<int>(std::min(std::sqrt(range_sq) * ranges.steps_per_m, farthest));
    const cube_map::reference::Projection at = cube_map::reference::project(x, y, z, 0.5f * kFineSide);
    const int u = cube_map::reference::pixel(at.u, kFineSide), v = cube_map::reference::pixel(at.v, kFineSide);
    out->fine[i] = (at.face * kFineSide + v) * kFineSide + u;
    out->coarse[i] = (at.face * kCoarseSide + v / kFineToCoarse) * kCoarseSide + u / kFineToCoarse;
  }
}

}  // namespace voxnav::kernels
