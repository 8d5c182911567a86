// SPDX-License-Identifier: BSD-3-Clause
#include "planning/path/run_costs.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace voxnav::planning {
namespace {
constexpr int kSide = geometry::kBlockSide;

CellCost cost_from(double cost) { return static_cast<CellCost>(std::min(65535.0, cost * kUnitCost)); }
}  // namespace

RunCosts::RunCosts(const ClearanceField& field, const PathPlannerConfig& config, const geometry::Vec3& start)
    : field_(field.impl()), config_(config), start_(start) {
  const double resolution = field.resolution_m();
  has_start_rules_ = config.unknown_policy == UnknownPolicy::kOptimisticFar;
  is_known_only_ = config.unknown_policy == UnknownPolicy::kForbid;
  const double known = has_start_rules_ ? config.known_distance_m : 0.0;
  const double safety = field_.clearance_m() / resolution;
  const double clearance = std::max(safety, config.clearance_distance_m / resolution);
  const bool has_extra = clearance > safety && config.clearance_weight > 0.0;
  if (has_extra && config.clearance_distance_m > field.config().radius_m) {
    throw std::invalid_argument("radius_m of the clearance field is less than clearance_distance_m");
  }
  if (known > field_.unknown_radius_m()) {
    throw std::invalid_argument("unknown_radius_m of the clearance field is less than known_distance_m");
  }
  known_squared_ = 4.0 * std::pow(known / resolution, 2);
  unknown_cost_ = static_cast<CellCost>(std::lround(config.unknown_cost * kUnitCost));
  has_unit_costs_ = !has_extra && known_squared_ == 0.0 && config.unknown_policy == UnknownPolicy::kForbid;
  if (!has_extra) return;
  dearest_ = cost_from(1.0 + config.clearance_weight);
  for (int squared = 0; std::sqrt(squared) / 2.0 < clearance; ++squared) {
    const double lack = (clearance - std::sqrt(squared) / 2.0) / (clearance - safety);
    extra_.push_back(cost_from(config.clearance_weight * std::min(1.0, lack) * std::min(1.0, lack)));
  }
}

bool RunCosts::is_near_start(const geometry::Index3& voxel) const {
  return (geometry::center_of(voxel, field_.resolution_m()) - start_).squaredNorm() <
         std::pow(config_.optimistic_range_m, 2);
}

bool RunCosts::touches_start_range(const geometry::Index3& block) const {
  const double side = kSide * field_.resolution_m();
  const geometry::Vec3 low = geometry::Vec3(block.x, block.y, block.z) * side;
  const geometry::Vec3 nearest = start_.cwiseMax(low).cwiseMin(low + geometry::Vec3::Constant(side));
  return (nearest - start_).squaredNorm() < std::pow(config_.optimistic_range_m, 2);
}

void RunCosts::find_tower(int x, int y, std::vector<TowerBlock>* tower) const {
  tower->clear();
  const VoxelBox& bounds = field_.bounds();
  for (int z = bounds.low.z & ~(kSide - 1); z <= bounds.high.z; z += kSide) {
    const geometry::Index3 voxel{x, y, z};
    const ClearanceBlock* block = field_.block_of(voxel);
    const bool is_near = has_start_rules_ && touches_start_range(geometry::block_of(voxel));
    const bool is_uniform = block != nullptr && !is_near && (extra_.empty() || block->to_occupied == nullptr);
    tower->push_back({block, z, is_near, is_uniform});
  }
}

bool RunCosts::is_plain(const std::vector<TowerBlock>& tower) const {
  const auto is_plain = [](const TowerBlock& in) { return in.block == nullptr || in.is_uniform; };
  return is_known_only_ && tower.size() * kSide <= 64 && std::all_of(tower.begin(), tower.end(), is_plain);
}

std::uint16_t RunCosts::enterable_unknown(const TowerBlock& in, int x, int y) const {
  const int column = column_at(x & (kSide - 1), y & (kSide - 1));
  std::uint32_t out = 0;
  if (in.block != nullptr) {
    out = in.block->passable[column];
  } else {
    const VoxelBox inside = part_in(field_.bounds(), geometry::block_of({x, y, in.lowest_z}));
    const geometry::Index3 v{x & (kSide - 1), y & (kSide - 1), inside.low.z};
    if (inside.contains(v)) out = ((2u << inside.high.z) - 1u) & ~((1u << inside.low.z) - 1u);
  }
  if (!in.touches_start_range) return static_cast<std::uint16_t>(out);
  const std::uint32_t unknown = in.block != nullptr ? in.block->unknown[column] : kWholeColumn;
  for (std::uint32_t bits = out & unknown; bits != 0; bits &= bits - 1) {
    const int z = __builtin_ctz(bits);
    if (is_near_start({x, y, in.lowest_z + z})) out &= ~(1u << z);
  }
  return static_cast<std::uint16_t>(out);
}

int RunCosts::last_alike(const TowerBlock& in, int column, int low, int high) const {
  if (in.block == nullptr) return high;
  // Near the start, a cell's place decides as well.
  if (in.touches_start_range) return low;
  const std::uint32_t unknown = in.block->unknown[column];
  const ClearanceDistances* distances = in.block->to_occupied.get();
  const std::int16_t* squared =
      distances != nullptr ? &(*distances)[static_cast<std::size_t>(column) * kSide] : nullptr;
  int z = low;
  while (z < high && ((unknown ^ (unknown >> 1)) >> z & 1u) == 0 &&
         (squared == nullptr || squared[z + 1] == squared[low])) {
    ++z;
  }
  return z;
}

CellCost RunCosts::cost_of(const ClearanceBlock* block, const geometry::Index3& voxel) const {
  if (block == nullptr) return unknown_cost_;
  const int offset = geometry::offset_in_block(voxel);
  const int column = offset % kColumns, z = offset / kColumns;
  const bool is_unknown = ((block->unknown[column] >> z) & 1) != 0;
  int cost = is_unknown ? unknown_cost_ : kUnitCost;
  if (block->to_occupied != nullptr) {
    const auto squared = static_cast<std::size_t>((*block->to_occupied)[kSide * column + z]);
    if (squared < extra_.size()) cost += extra_[squared];
  }
  if (has_start_rules_ && known_squared_ > 0.0 && block->to_unknown != nullptr &&
      (*block->to_unknown)[kSide * column + z] < known_squared_ && is_near_start(voxel)) {
    cost += static_cast<int>(config_.near_unknown_weight * kUnitCost);
  }
  return static_cast<CellCost>(std::min(65535, cost));
}

CellCost RunCosts::gap_cost(const geometry::Index3& voxel) const {
  const ClearanceBlock* block = field_.block_of(voxel);
  if (block == nullptr || !field_.bounds().contains(voxel)) return 0;
  const int offset = geometry::offset_in_block(voxel);
  const int column = offset % kColumns, z = offset / kColumns;
  const std::uint32_t closed =
      block->occupied[column] | block->unknown[column] | block->hard[column] | block->soft[column];
  return ((closed >> z) & 1u) != 0 ? CellCost{0} : dearest_;
}

}  // namespace voxnav::planning
