// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bitset>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>

#include "planning/clearance/block_columns.hpp"
#include "planning/fences/polygon.hpp"
#include "voxnav/planning/fences.hpp"

namespace voxnav::planning {

/// How far planned paths stay from fences.
struct FenceMargins {
  double area_m = 0.0;  ///< from the sides of the area, inside it
  double zone_m = 0.0;  ///< from zones, on all sides
};

/// The voxels of a grid that paths may not enter because of fences. A voxel may be entered only if the whole of its
/// cube keeps the margins, so that every line through voxels that may be entered keeps them as well. The heights of the
/// area are left to limits of altitude. Each block is computed when it is first asked for, and kept, since the planner
/// compares all blocks each time it plans. Thread-safe.
class FenceRaster {
 public:
  /// @param fences  not null
  FenceRaster(std::shared_ptr<const Fences> fences, const FenceMargins& margins, double resolution_m);

  /// ORs the voxels of a block that may not be entered into a mask. @return false if there are none
  bool mask(const geometry::Index3& block, BlockMask* hard) const;

  /// Appends the blocks within a box that hold voxels of both kinds, or lie beside such a block: a path from inside the
  /// fences passes them before any other block that may not be entered. O(blocks of the box in fenced columns).
  void add_edge_blocks(const geometry::Aabb& box, std::vector<geometry::Index3>* out) const;

  bool is_of(const Fences* fences, double resolution_m) const {
    return fences == fences_.get() && resolution_m == resolution_m_;
  }
  const Fences& fences() const { return *fences_; }
  const std::shared_ptr<const Fences>& shared_fences() const { return fences_; }

 private:
  /// Heights of voxels, both included; none if low is above high.
  struct Band {
    int low = 0;
    int high = -1;
  };
  struct ZoneBands {
    std::array<Band, kColumns> bands;
    Band some;  ///< heights at which a voxel of the column of blocks is fenced
    Band all;   ///< heights at which all voxels of it are fenced
  };
  /// What is fenced in a column of blocks.
  struct Cover {
    std::bitset<kColumns> outside;  ///< columns of voxels that are not inside the area
    bool is_all_outside = false;
    std::optional<bool> is_deep;  ///< all columns of blocks around it are outside as well; known when first asked for
    std::vector<ZoneBands> zones;
  };
  enum class Share { kNone, kSome, kAll };

  /// The cover of a column of blocks, null if nothing is fenced there. The lock must be held.
  Cover* cover(int x, int y) const;
  std::unique_ptr<Cover> make_cover(int x, int y) const;
  Rectangle square(int x, int y, int side) const;
  std::bitset<kColumns> outside_area(const Prism& area, int x, int y) const;
  void add_zone(const Prism& zone, int x, int y, Cover* cover) const;
  Share share(int x, int y, int z) const;
  bool is_at_edge(int x, int y, int z) const;
  bool is_deep_outside(int x, int y) const;
  /// The mask of a block of which some voxels are fenced.
  std::unique_ptr<BlockMask> make_mask(const Cover& there, int z) const;

  std::shared_ptr<const Fences> fences_;
  FenceMargins margins_;
  double resolution_m_;
  mutable std::mutex mutex_;
  mutable std::unordered_map<geometry::Index3, std::unique_ptr<Cover>, geometry::Index3Hash> covers_;
  mutable std::unordered_map<geometry::Index3, std::unique_ptr<BlockMask>, geometry::Index3Hash> masks_;
};

}  // namespace voxnav::planning
