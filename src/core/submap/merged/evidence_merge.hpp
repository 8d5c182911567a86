// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "submap/merged/placed_submap.hpp"
#include "voxnav/submap/evidence_map.hpp"

namespace voxnav::submap {

/// Merges the evidence of a newer submap into one block of W. Its surface points replace the older ones of their
/// voxels. Its free space removes other older points, but only once both the voxel of a point and the one below it were
/// observed: until then the point is in doubt, since a sparse sensor observes the two at different times.
/// A point that beams passed closely below and above is treated like one in observed free space.
class EvidenceMerge {
 public:
  /// All arguments must outlive this object.
  /// @param around  points of the newer submap in the block and around it
  /// @param block   evidence so far, which is updated
  EvidenceMerge(const EvidenceRules& rules, const PlacedSubmap& submap, const PlacedPoints::Around& around,
                EvidenceBlock* block);
  /// O(surface points of the block + 16^2).
  void run();

 private:
  bool doubt();
  void remove_doubted();
  void drop_replaced();
  void add_points(const PlacedPoints::Block& points);
  bool is_passed(const SurfaceEvidence& point, const FreeAt& free) const;
  bool is_near_enough(const SurfaceEvidence& evidence) const;

  const EvidenceRules& rules_;
  const PlacedSubmap& submap_;
  const PlacedPoints::Around& around_;
  EvidenceBlock* block_;
  PlacedSubmap::FreeInBlock free_;
  const Columns& seen_;  ///< voxels in which the submap has points
};

/// Returns true if every voxel of a block is known, so that more free space adds nothing.
bool is_decided(const ColumnBlock& states);

}  // namespace voxnav::submap
