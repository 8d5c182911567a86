// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "kernels/place_points.hpp"
#include "kernels/point_sum.hpp"
#include "voxnav/geometry/voxel.hpp"

namespace voxnav::occupancy {

/// The transform and the limits with which points of one scan become ends of rays.
struct ScanFrame : kernels::PlacementFrame {
  bool clear_beyond_range;

  bool contains(const geometry::Vec3f& end) const { return (end.array() >= low).all() && (end.array() <= high).all(); }
  /// Returns the last point inside the window on the line from the sensor to `end`, which lies outside.
  geometry::Vec3f clipped(const geometry::Vec3f& end) const;
};

/// Consecutive points of a scan that lie in one voxel, summed. Neighbouring beams mostly end in the same voxel, so most
/// of the sorting is done before any voxel is looked up.
struct EndRun : kernels::PointSum {  // a base class, so that the voxel lies in the padding of the sum
  geometry::Index3 voxel{-1, -1, -1};
};

/// The part of a scan that one thread prepares: runs of end points, ends of cut beams, and counts of points left out.
class ScanPart {
 public:
  void clear();
  /// Adds n points; x y z come first in every `stride` floats. Runs end every kChunk points, so that sums do not depend
  /// on how a scan is split, as long as parts begin at multiples of kChunk.
  void add(const float* points, std::size_t n, std::size_t stride, const ScanFrame& frame);
  static constexpr std::size_t kChunk = 1024;

  const std::vector<EndRun>& runs() const { return runs_; }
  /// The ends of beams that were cut because they reach beyond the window or the range. Their rays clear the space up
  /// to there and hit nothing.
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
