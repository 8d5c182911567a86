// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/scan_part.hpp"

#include <algorithm>

namespace voxnav::occupancy {

geometry::Vec3f ScanFrame::clipped(const geometry::Vec3f& end) const {
  float share = 1.0f;
  for (int axis = 0; axis < 3; ++axis) {
    const float delta = end[axis] - origin[axis];
    if (delta == 0.0f) continue;
    share = std::min(share, ((delta > 0.0f ? high[axis] : low[axis]) - origin[axis]) / delta);
  }
  const geometry::Vec3f inside = origin + std::max(share, 0.0f) * (end - origin);
  return inside.array().max(low).min(high).matrix();  // rounding
}

void ScanPart::clear() {
  runs_.clear();
  clearing_ends_.clear();
  num_not_finite_ = num_too_near_ = num_far_ = num_outside_ = 0;
}

void ScanPart::add(const float* points, std::size_t n, std::size_t stride, const ScanFrame& frame) {
  runs_.reserve(n / 3);  // most scans make no more, and doubling would take more
  for (std::size_t i = 0; i < n; i += kChunk) {
    add_chunk(points + i * stride, std::min(kChunk, n - i), stride, frame);
  }
}

void ScanPart::add_chunk(const float* points, std::size_t n, std::size_t stride, const ScanFrame& frame) {
  const float nearest_sq = frame.nearest_m * frame.nearest_m;
  const float farthest_sq = frame.farthest_m * frame.farthest_m;
  EndRun run;
  const auto flush = [&] {
    if (run.voxel.x >= 0) runs_.push_back(run);
  };
  for (std::size_t i = 0; i < n; ++i) {
    const geometry::Vec3f p_L(points[i * stride], points[i * stride + 1], points[i * stride + 2]);
    const float range_sq = p_L.squaredNorm();
    const geometry::Vec3f end = frame.origin + frame.rotation * p_L;
    // Written so that NaN fails.
    if (!(range_sq >= nearest_sq && range_sq <= farthest_sq && frame.contains(end))) {
      add_odd(p_L, frame);
      continue;
    }
    // Coordinates in the window are never negative, so truncation is floor.
    const geometry::Index3 voxel{static_cast<int>(end.x()), static_cast<int>(end.y()), static_cast<int>(end.z())};
    if (voxel != run.voxel) {
      flush();
      run = EndRun{};
      run.voxel = voxel;
    }
    run.add(geometry::Vec3f(end.x() - (static_cast<float>(voxel.x) + 0.5f),
                            end.y() - (static_cast<float>(voxel.y) + 0.5f),
                            end.z() - (static_cast<float>(voxel.z) + 0.5f)));
  }
  flush();
}

void ScanPart::add_odd(const geometry::Vec3f& p_L, const ScanFrame& frame) {
  if (!p_L.allFinite()) {
    ++num_not_finite_;
  } else if (p_L.stableNorm() < frame.nearest_m) {
    ++num_too_near_;
  } else if (p_L.stableNorm() > frame.farthest_m) {
    ++num_far_;
    if (!frame.clear_beyond_range) return;
    const geometry::Vec3f end = frame.origin + frame.rotation * p_L.stableNormalized() * frame.farthest_m;
    clearing_ends_.push_back(frame.clipped(end));
  } else {
    ++num_outside_;
    clearing_ends_.push_back(frame.clipped(frame.origin + frame.rotation * p_L));
  }
}

}  // namespace voxnav::occupancy
