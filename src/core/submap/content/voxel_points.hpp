// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "submap/content/ranked_bits.hpp"
#include "voxnav/occupancy/map_content.hpp"

namespace voxnav::submap {

/// The surface points of the occupied voxels of a submap, numbered in the order of its blocks, cells and voxels
/// (BlockStates). Each is an occupancy::OccupiedVoxel, with the believed and the observed point. They are packed: a
/// point that is only remembered takes four bytes, an observed one five, and four more if the hits during the submap
/// alone give another point than all hits together. Immutable once finish() was called.
class VoxelPoints {
 public:
  void reserve(std::size_t count) { believed_.reserve(count); }
  void add(const occupancy::OccupiedVoxel& voxel);
  void finish();

  std::size_t size() const { return believed_.size(); }
  std::size_t num_observed() const { return times_.size(); }
  /// Returns how many points before a number, which may be the end, were observed.
  std::size_t num_observed_before(std::size_t number) const { return is_observed_.rank(number); }
  bool is_observed(std::size_t number) const { return is_observed_.test(number); }
  const occupancy::VoxelPoint& believed(std::size_t number) const { return believed_[number]; }
  /// Returns true if every point was observed and its believed point is the observed one.
  bool all_observed() const { return times_.size() == believed_.size() && observed_.empty(); }
  /// Returns the phase at which the submap observed a point: 0 at its beginning, 1 at its end; one half unless it
  /// observed all points.
  float phase_of(std::size_t number) const {
    const bool is_known = times_.size() == believed_.size();
    return is_known ? static_cast<float>(times_[number]) / 255.0f : 0.5f;
  }
  /// Replaces the points by others in the same voxels. Precondition: all_observed().
  /// @param points  one for each number
  void move_to(std::vector<occupancy::VoxelPoint> points);

  /// Reads points one after another, which saves the rank queries that random access needs.
  class Reader {
   public:
    /// @param number  number of the first point to read
    Reader(const VoxelPoints& points, std::size_t number)
        : points_(points),
          number_(number),
          observed_(points.is_observed_.rank(number)),
          differing_(points.differs_.rank(observed_)) {}
    /// Reads the next point. The offset of its voxel is not set, since it is stored in BlockStates.
    void next(occupancy::OccupiedVoxel* out) {
      out->believed = points_.believed_[number_];
      out->observed = {};
      out->observed_time = occupancy::kUnknownTime;
      if (!points_.is_observed_.test(number_++)) return;
      out->observed_time = points_.times_[observed_];
      out->observed = points_.differs_.test(observed_++) ? points_.observed_[differing_++] : out->believed;
    }

   private:
    const VoxelPoints& points_;
    std::size_t number_;
    std::size_t observed_;   ///< number of the next observed point among all observed ones
    std::size_t differing_;  ///< number of the next point whose observation differs, among all such points
  };

  /// The serialised parts.
  struct Parts {
    std::vector<occupancy::VoxelPoint> believed;
    std::vector<std::uint8_t> times;
    std::vector<occupancy::VoxelPoint> observed;
    std::vector<std::uint64_t> observed_words, differing_words;
  };
  /// Takes parts that were read. @return false if they do not fit each other
  bool assign(Parts parts);
  const std::vector<occupancy::VoxelPoint>& all_believed() const { return believed_; }
  const std::vector<std::uint8_t>& times() const { return times_; }
  const std::vector<occupancy::VoxelPoint>& differing() const { return observed_; }
  const RankedBits& observed_bits() const { return is_observed_; }
  const RankedBits& differing_bits() const { return differs_; }
  std::size_t memory_bytes() const;

 private:
  std::vector<occupancy::VoxelPoint> believed_;
  RankedBits is_observed_;                       ///< whether each point was observed
  std::vector<std::uint8_t> times_;              ///< times of the observed ones, from 0 (submap's begin) to 255 (end)
  RankedBits differs_;                           ///< whether the observation of each observed one is another point
  std::vector<occupancy::VoxelPoint> observed_;  ///< observations of those that differ
};

}  // namespace voxnav::submap
