// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>

#include "voxnav/containers/state_grid.hpp"
#include "voxnav/planning/occupancy_view.hpp"

namespace voxnav::pipeline {

/// Limits of the height above the terrain, in voxels. A voxel may be entered from ground + low to ground + high, both
/// included, where ground is the highest voxel that the terrain fills in its column.
struct HeightLimits {
  std::optional<int> low, high;
};

/// The terrain in a column of blocks. Immutable, but for masks that are made when they are first asked for.
class TerrainColumn {
 public:
  static constexpr int kSide = geometry::kBlockSide;
  static constexpr std::size_t kColumns = std::size_t{kSide} * kSide;
  static constexpr std::int32_t kUnknown = std::numeric_limits<std::int32_t>::max();
  /// Heights in voxels, x fastest; those that are not known are kUnknown.
  using Heights = std::array<std::int32_t, kColumns>;

  TerrainColumn(const Heights& lowest_occupied, const Heights& ground);

  const Heights& lowest_occupied() const { return lowest_occupied_; }
  const Heights& ground() const { return ground_; }
  bool is_known_anywhere() const { return low_ != kUnknown; }

  /// ORs the voxels of the block at a height that are outside the limits into a mask. The limits must be the same in
  /// all calls. Thread-safe. @return false if there are none
  bool forbid(int block_z, const HeightLimits& limits, planning::BlockMask* hard) const;

 private:
  /// The voxels of a column within a block that are outside the limits, one bit for each height.
  static std::uint32_t outside(std::int32_t ground, int block_z, const HeightLimits& limits);
  std::unique_ptr<planning::BlockMask> make_mask(int block_z, const HeightLimits& limits) const;

  Heights lowest_occupied_, ground_;
  std::int32_t low_ = kUnknown, high_ = kUnknown;  ///< of the ground where it is known
  bool is_known_everywhere_ = true;
  mutable std::mutex mutex_;
  mutable std::unordered_map<int, std::unique_ptr<planning::BlockMask>> masks_;
};

/// The height of the terrain under a vehicle: in each column of voxels the lowest occupied one, without what rises from
/// the ground on less than a window's width, such as trunks, poles and crowns under which no ground was seen. Known in
/// blocks of the map where it holds something occupied within a window's width, up to kRadius voxels from the vehicle.
/// Immutable.
/// Source: Zhang et al., A progressive morphological filter for removing nonground measurements, IEEE Transactions on
/// Geoscience and Remote Sensing 2003, section II (opening), here with a single window.
class TerrainMap {
 public:
  /// Half the width of the window, and the distance in voxels up to which columns are looked at.
  static constexpr double kWindow_m = 3.0;
  static constexpr int kRadius = 512;
  using Columns = std::unordered_map<geometry::Index3, std::shared_ptr<const TerrainColumn>, geometry::Index3Hash>;

  /// O(blocks of the grid, and columns of voxels within 2 windows of what has changed since `before`).
  /// @param before  an earlier map, whose columns are kept where nothing has changed; may be null
  TerrainMap(const containers::StateGrid& grid, const geometry::Vec3& vehicle, const TerrainMap* before = nullptr);

  /// Returns the height of the terrain's surface at a column of voxels; nothing where it is not known.
  std::optional<double> height_m(int x, int y) const;
  /// Returns the terrain in a column of blocks; null if the map holds none there.
  const TerrainColumn* column(int block_x, int block_y) const;
  /// All columns of blocks, by their indices at height 0.
  const Columns& columns() const { return columns_; }
  double resolution_m() const { return resolution_m_; }

 private:
  using Lowest = std::unordered_map<geometry::Index3, TerrainColumn::Heights, geometry::Index3Hash>;
  static Lowest read(const containers::StateGrid& grid, const geometry::Vec3& vehicle);
  TerrainColumn::Heights ground_of(const geometry::Index3& block, const Lowest& lowest) const;

  double resolution_m_;
  int reach_;  ///< half the width of the window in voxels
  Columns columns_;
};

/// Keeps the newest terrain, of which the next one is made. Thread-safe.
class TerrainSource {
 public:
  std::shared_ptr<const TerrainMap> terrain_of(const containers::StateGrid& grid, const geometry::Vec3& vehicle);

 private:
  std::mutex mutex_;
  std::shared_ptr<const TerrainMap> newest_;
};

}  // namespace voxnav::pipeline
