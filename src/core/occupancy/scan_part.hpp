// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "kernels/place_points.hpp"
#include "kernels/point_sum.hpp"
#include "voxnav/geometry/voxel.hpp"

namespace voxnav::occupancy {

/// How points of one scan are turned into ends of rays.
struct ScanFrame : kernels::PlacementFrame {
  bool clear_beyond_range;

  bool contains(const geometry::Vec3f& end) const { return (end.array() >= low).all() && (end.array() <= high).all(); }
  /// The last point inside the window on the way from the sensor to `end`, which lies outside.
  geometry::Vec3f clipped(const geometry::Vec3f& end) const;
};

/// Points of one voxel that came one after the other: neighbouring beams mostly end together, so most of the sorting
/// is done before any voxel is looked up.
struct EndRun : kernels::PointSum {  // a base class, so that the voxel lies in the padding of the sum
  geometry::Index3 voxel{-1, -1, -1};
};

/// What one thread made of its part of a scan.
class ScanPart {
 public:
  void clear();
  /// Adds n points; x y z come first in every `stride` floats. Runs end every kChunk points, so that sums do not depend
  /// on how a scan is split, as long as parts begin at multiples of kChunk.
  void add(const float* points, std::size_t n, std::size_t stride, const ScanFrame& frame);
  static constexpr std::size_t kChunk = 1024;

  const std::vector<EndRun>& runs() const { return runs_; }
  /// Where beams that ended beyond the window or the range were cut: they free what lies before, and hit nothing.
  const std::vector<geometry::Vec3f>& clearing_ends() const { return clearing_ends_; }
  std::size_t num_not_finite() const { return num_not_finite_; }
  std::size_t num_too_near() const { return num_too_near_; }
  std::size_t num_far() const { return num_far_; }
  std::size_t num_outside() const { return num_outside_; }
  std::size_t memory_bytes() const {
    return runs_.capacity() * sizeof(EndRun) + clearing_ends_.capacity() * sizeof(geometry::Vec3f);
  }

 private:
  void add_chunk(const float* points, std::size_t n, std::size_t stride, const ScanFrame& frame);
  void add_odd(const geometry::Vec3f& p_L, const ScanFrame& frame);

  std::vector<EndRun> runs_;
  std::vector<geometry::Vec3f> clearing_ends_;
  std::size_t num_not_finite_ = 0, num_too_near_ = 0, num_far_ = 0, num_outside_ = 0;
};

}  // namespace voxnav::occupancy
