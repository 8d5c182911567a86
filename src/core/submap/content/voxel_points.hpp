// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "submap/content/ranked_bits.hpp"
#include "voxnav/occupancy/map_content.hpp"

namespace voxnav::submap {

/// The surface points of the occupied voxels of a submap, numbered in the order of its blocks, cells and voxels
/// (BlockStates). Each is one occupancy::OccupiedVoxel: what is believed, and what the submap observed itself. Kept
/// packed: of a point that was only remembered four bytes, of one that the submap observed five, and four more where
/// its observation alone gives another point than all hits together. Frozen once finish() was called.
class VoxelPoints {
 public:
  void reserve(std::size_t count) { believed_.reserve(count); }
  void add(const occupancy::OccupiedVoxel& voxel);
  void finish();

  std::size_t size() const { return believed_.size(); }
  std::size_t num_observed() const { return times_.size(); }
  /// Observed ones before a number, which may be the end.
  std::size_t num_observed_before(std::size_t number) const { return is_observed_.rank(number); }
  bool is_observed(std::size_t number) const { return is_observed_.test(number); }
  const occupancy::VoxelPoint& believed(std::size_t number) const { return believed_[number]; }
  /// Whether every point is exactly what the submap observed itself.
  bool all_observed() const { return times_.size() == believed_.size() && observed_.empty(); }
  /// When the submap observed a point, as a share of its time from beginning to end; one half unless it observed all.
  float phase_of(std::size_t number) const {
    const bool is_known = times_.size() == believed_.size();
    return is_known ? static_cast<float>(times_[number]) / 255.0f : 0.5f;
  }
  /// Other points for the same voxels; only where all_observed(). @param points  one per number
  void move_to(std::vector<occupancy::VoxelPoint> points);

  /// Reads points one after another, which needs no search for what belongs to each.
  class Reader {
   public:
    /// @param number  of the first one
    Reader(const VoxelPoints& points, std::size_t number)
        : points_(points),
          number_(number),
          observed_(points.is_observed_.rank(number)),
          differing_(points.differs_.rank(observed_)) {}
    /// Everything but the offset, which the points do not know.
    void next(occupancy::OccupiedVoxel* out);

   private:
    const VoxelPoints& points_;
    std::size_t number_;
    std::size_t observed_;   ///< number of the next one among those that were observed
    std::size_t differing_;  ///< and among those of which the observation differs
  };

  /// What the codec writes and reads.
  struct Parts {
    std::vector<occupancy::VoxelPoint> believed;
    std::vector<std::uint8_t> times;
    std::vector<occupancy::VoxelPoint> observed;
    std::vector<std::uint64_t> observed_words, differing_words;
  };
  /// @return false when the parts do not fit each other
  bool assign(Parts parts);
  const std::vector<occupancy::VoxelPoint>& all_believed() const { return believed_; }
  const std::vector<std::uint8_t>& times() const { return times_; }
  const std::vector<occupancy::VoxelPoint>& differing() const { return observed_; }
  const RankedBits& observed_bits() const { return is_observed_; }
  const RankedBits& differing_bits() const { return differs_; }
  std::size_t memory_bytes() const;

 private:
  std::vector<occupancy::VoxelPoint> believed_;
  RankedBits is_observed_;                       ///< for each of them
  std::vector<std::uint8_t> times_;              ///< of the observed ones, 0 to 255 from the submap's begin to its end
  RankedBits differs_;                           ///< for each of the observed ones: the observation is another point
  std::vector<occupancy::VoxelPoint> observed_;  ///< of those that differ
};

}  // namespace voxnav::submap
