// SPDX-License-Identifier: BSD-3-Clause
#include "kernels/place_points.hpp"

#include "kernels/lanes.hpp"

namespace voxnav::kernels {
namespace {

using namespace lanes;  // NOLINT: the vector types of this file

VOXNAV_INLINE void place(const PointBatch& batch, const PlacementFrame& frame, PlacedBatch* out) {
  const float nearest_sq = frame.nearest_m * frame.nearest_m;
  const float farthest_sq = frame.farthest_m * frame.farthest_m;
  for (std::size_t i = 0; i < PointBatch::kSize; i += kLanes) {
    const auto x = loaded<Floats>(batch.x + i), y = loaded<Floats>(batch.y + i), z = loaded<Floats>(batch.z + i);
    const Floats range_sq = x * x + y * y + z * z;
    Ints is_end = (range_sq >= nearest_sq) & (range_sq <= farthest_sq);  // NaN fails both comparisons
    for (int axis = 0; axis < 3; ++axis) {
      const Floats end = frame.origin[axis] +
                         (frame.rotation(axis, 0) * x + frame.rotation(axis, 1) * y + frame.rotation(axis, 2) * z);
      const Ints is_inside = (end >= frame.low[axis]) & (end <= frame.high[axis]);
      is_end &= is_inside;
      const Floats safe = is_inside ? end : Floats{};
      // Coordinates in the window are never negative, so truncation is floor.
      const Ints voxel = truncated(safe);
      store(voxel, out->voxel[axis] + i);
      store(safe - (floats(voxel) + 0.5f), out->offset[axis] + i);
    }
    store(is_end, out->is_end + i);
  }
}
void place_plain(const PointBatch& batch, const PlacementFrame& frame, PlacedBatch* out) { place(batch, frame, out); }
VOXNAV_WIDE void place_wide(const PointBatch& batch, const PlacementFrame& frame, PlacedBatch* out) {
  place(batch, frame, out);
}

}  // namespace

void place_points(const PointBatch& batch, const PlacementFrame& frame, PlacedBatch* out) {
  (is_wide() ? place_wide : place_plain)(batch, frame, out);
}

void reference::place_points(const PointBatch& batch, const PlacementFrame& frame, PlacedBatch* out) {
  for (std::size_t i = 0; i < PointBatch::kSize; ++i) {
    const float x = batch.x[i], y = batch.y[i], z = batch.z[i];
    const float range_sq = x * x + y * y + z * z;
    bool is_end = range_sq >= frame.nearest_m * frame.nearest_m && range_sq <= frame.farthest_m * frame.farthest_m;
    for (int axis = 0; axis < 3; ++axis) {
      const float end = frame.origin[axis] +
                        (frame.rotation(axis, 0) * x + frame.rotation(axis, 1) * y + frame.rotation(axis, 2) * z);
      const bool is_inside = end >= frame.low[axis] && end <= frame.high[axis];
      is_end = is_end && is_inside;
      out->voxel[axis][i] = is_inside ? static_cast<std::int32_t>(end) : 0;
      out->offset[axis][i] = (is_inside ? end : 0.0f) - (static_cast<float>(out->voxel[axis][i]) + 0.5f);
    }
    out->is_end[i] = is_end ? -1 : 0;
  }
}

}  // namespace voxnav::kernels
