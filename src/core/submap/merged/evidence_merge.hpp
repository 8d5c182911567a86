// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "submap/merged/placed_submap.hpp"
#include "voxnav/submap/evidence_map.hpp"

namespace voxnav::submap {

/// What a newer submap says of one block of W, added to what is believed of it. Its surface points replace the older
/// ones of their voxels. Its free space removes other older ones, but only once it was seen at a voxel and below it:
/// until then the point is in doubt, since a sparse sensor sees both at different times.
class EvidenceMerge {
 public:
  /// @param around  the points of the submap around the block  @param block  what is believed. No argument may end
  /// before this does
  EvidenceMerge(const EvidenceRules& rules, const PlacedSubmap& submap, const PlacedPoints::Around& around,
                EvidenceBlock* block);
  /// O(surface points of the block + 16^2).
  void run();

 private:
  bool doubt();
  void remove_doubted();
  void drop_replaced();
  void add_points(const PlacedPoints::Block& points);
  bool is_near_enough(const SurfaceEvidence& evidence) const;

  const EvidenceRules& rules_;
  const PlacedSubmap& submap_;
  const PlacedPoints::Around& around_;
  EvidenceBlock* block_;
  PlacedSubmap::FreeInBlock free_;
  const Columns& seen_;  ///< voxels in which the submap has points
};

/// Whether every voxel of a block is known, so that more free space says nothing new.
bool is_decided(const ColumnBlock& states);

}  // namespace voxnav::submap
