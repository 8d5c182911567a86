// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <unordered_map>

#include "planning/clearance/flyable_parts.hpp"
#include "planning/clearance/squared_distances.hpp"

namespace voxnav::planning {

/// Lowest and highest voxel of a box, both included.
struct VoxelBox {
  geometry::Index3 low{0, 0, 0};
  geometry::Index3 high{-1, -1, -1};

  bool contains(const geometry::Index3& v) const {
    return v.x >= low.x && v.y >= low.y && v.z >= low.z && v.x <= high.x && v.y <= high.y && v.z <= high.z;
  }
  friend bool operator==(const VoxelBox& a, const VoxelBox& b) { return a.low == b.low && a.high == b.high; }
  friend bool operator!=(const VoxelBox& a, const VoxelBox& b) { return !(a == b); }
};

/// The voxels whose centres are in the bounds of a view.
VoxelBox voxels_in(const geometry::Aabb& bounds, double resolution_m);
/// The part of a box that lies in a block, in voxels of the block; all empty parts are equal.
VoxelBox part_in(const VoxelBox& box, const geometry::Index3& block);

/// A block of a clearance field: a copy of the map, and what follows from it.
struct ClearanceBlock {
  geometry::Index3 index;
  StateBlock states;
  BlockColumns occupied{};
  BlockColumns unknown{};
  std::array<std::uint16_t, geometry::kBlockSide> occupied_rows{};  ///< by y: bit x of columns with occupied voxels
  BlockColumns hard{};                                              ///< forbidden by the view or outside its bounds
  BlockColumns soft{};  ///< forbidden by the view unless all is known within the safety distance
  bool has_hard = false;
  bool has_soft = false;
  VoxelBox inside;          ///< part of the block within the bounds
  BlockColumns passable{};  ///< clear of obstacles and not forbidden, known to be free or unknown
  BlockColumns flyable{};   ///< passable and known to be free
  std::unique_ptr<ClearanceDistances> to_occupied;  ///< null: all kFar
  std::unique_ptr<ClearanceDistances> to_unknown;
  FlyableParts parts;
  std::array<FlyableParts::Contacts, 3> contacts;  ///< with the next block along each axis
  std::vector<std::uint16_t> outer_parts;          ///< parts that touch unknown blocks which the field does not hold
  std::uint32_t first_part = 0;                    ///< number of its first part among those of the whole field
  std::array<std::int32_t, 27> neighbours;         ///< slots, kNoSlot where there is no block; the block itself at 13

  static constexpr std::int32_t kNoSlot = -1;
  /// Memory of a block with all its distances, with a share for its parts and its place in the table.
  static std::size_t max_bytes();
};

/// The blocks of a field by slot and by index, each with the slots of the blocks around it.
class ClearanceBlocks {
 public:
  std::int32_t find(const geometry::Index3& index) const;
  std::int32_t insert(const geometry::Index3& index);
  void remove(std::int32_t slot);
  void clear() { *this = ClearanceBlocks(); }

  ClearanceBlock& at(std::int32_t slot) { return *blocks_[static_cast<std::size_t>(slot)]; }
  const ClearanceBlock& at(std::int32_t slot) const { return *blocks_[static_cast<std::size_t>(slot)]; }
  bool has(std::int32_t slot) const { return blocks_[static_cast<std::size_t>(slot)] != nullptr; }
  /// One more than the highest slot in use.
  std::int32_t end() const { return static_cast<std::int32_t>(blocks_.size()); }
  std::size_t size() const { return slots_.size(); }
  const std::unordered_map<geometry::Index3, std::int32_t, geometry::Index3Hash>& slots() const { return slots_; }

 private:
  void link(std::int32_t slot, const geometry::Index3& index, bool is_there);

  std::unordered_map<geometry::Index3, std::int32_t, geometry::Index3Hash> slots_;
  std::vector<std::unique_ptr<ClearanceBlock>> blocks_;
  std::vector<std::int32_t> unused_;
};

/// Position of the block (dx, dy, dz) away in ClearanceBlock::neighbours.
inline int neighbour_at(int dx, int dy, int dz) { return (dx + 1) + 3 * (dy + 1) + 9 * (dz + 1); }

}  // namespace voxnav::planning
