// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/scan_part.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace voxnav::occupancy {

using kernels::PointBatch;

geometry::Vec3f ScanFrame::clipped(const geometry::Vec3f& end) const {
  float share = 1.0f;
  for (int axis = 0; axis < 3; ++axis) {
    const float delta = end[axis] - origin[axis];
    if (delta == 0.0f) continue;
    share = std::min(share, ((delta > 0.0f ? high[axis] : low[axis]) - origin[axis]) / delta);
  }
  const geometry::Vec3f inside = origin + std::max(share, 0.0f) * (end - origin);
  return inside.array().max(low).min(high).matrix();  // rounding may have led out of the window
}

void ScanPart::clear() {
  runs_.clear();
  clearing_ends_.clear();
  num_not_finite_ = num_too_near_ = num_far_ = num_outside_ = 0;
}

void ScanPart::add(const float* points, std::size_t n, std::size_t stride, const ScanFrame& frame) {
  // Most scans have no more runs than this, and a vector that doubles its capacity would take more memory.
  runs_.reserve(n / 3);
  for (std::size_t i = 0; i < n; i += kChunk) {
    add_chunk(points + i * stride, std::min(kChunk, n - i), stride, frame);
  }
}

void ScanPart::add_chunk(const float* points, std::size_t n, std::size_t stride, const ScanFrame& frame) {
  PointBatch batch;
  kernels::PlacedBatch placed;
  EndRun run;
  const auto flush = [&] {
    if (run.voxel.x >= 0) runs_.push_back(run);
  };
  for (std::size_t begin = 0; begin < n; begin += PointBatch::kSize) {
    const std::size_t count = batch.load(points + begin * stride, n - begin, stride);
    kernels::place_points(batch, frame, &placed);
    for (std::size_t i = 0; i < count; ++i) {
      if (placed.is_end[i] == 0) {
        add_odd(geometry::Vec3f(batch.x[i], batch.y[i], batch.z[i]), frame);
        continue;
      }
      const geometry::Index3 voxel{placed.voxel[0][i], placed.voxel[1][i], placed.voxel[2][i]};
      if (voxel != run.voxel) {
        flush();
        run = EndRun{};
        run.voxel = voxel;
      }
      run.add(placed.offset[0][i], placed.offset[1][i], placed.offset[2][i]);
    }
  }
  flush();
}

void ScanPart::add_odd(const geometry::Vec3f& p_L, const ScanFrame& frame) {
  const float range_sq = p_L.squaredNorm();
  // The square of a large finite coordinate overflows to infinity, so the slower stableNorm() is used there.
  const float range_m = range_sq < std::numeric_limits<float>::max() ? std::sqrt(range_sq) : p_L.stableNorm();
  if (!p_L.allFinite()) {
    ++num_not_finite_;
  } else if (range_m < frame.nearest_m) {
    ++num_too_near_;
  } else if (range_m > frame.farthest_m) {
    ++num_far_;
    if (!frame.clear_beyond_range) return;
    const geometry::Vec3f last = p_L * (frame.farthest_m / range_m);
    const geometry::Vec3f end = frame.origin + frame.rotation * last;
    clearing_ends_.push_back(frame.contains(end) ? end : frame.clipped(end));
  } else {
    ++num_outside_;
    clearing_ends_.push_back(frame.clipped(frame.origin + frame.rotation * p_L));
  }
}

}  // namespace voxnav::occupancy
