// SPDX-License-Identifier: BSD-3-Clause
#include "planning/search_space.hpp"

namespace voxnav::planning {
namespace {
constexpr int kSide = geometry::kBlockSide;
}  // namespace

SearchSpace::SearchSpace(CellCosts* costs, std::uint64_t max_bytes) : costs_(costs), max_bytes_(max_bytes) {}

std::int64_t SearchSpace::number_of(const geometry::Index3& index) {
  const auto found = numbers_.find(index);
  if (found != numbers_.end()) return found->second;
  if (!blocks_.empty() && memory_bytes() + sizeof(Block) > max_bytes_) {
    has_refused_ = true;
    return kRefused;
  }
  auto block = std::make_unique<Block>();
  block->index = index;
  block->neighbours.fill(kUnresolved);
  block->g.fill(kUnreached);
  block->arrived_by.fill(kNoMove);
  costs_->compute(index, &block->costs);
  const auto number = static_cast<std::uint32_t>(blocks_.size());
  blocks_.push_back(std::move(block));
  numbers_.emplace(index, number);
  return number;
}

bool SearchSpace::locate(const geometry::Index3& voxel, CellRef* out) {
  const std::int64_t number = number_of(geometry::block_of(voxel));
  if (number < 0) return false;
  *out = {static_cast<std::uint32_t>(number), static_cast<std::uint16_t>(geometry::offset_in_block(voxel))};
  return true;
}

geometry::Index3 SearchSpace::voxel(CellRef cell) const {
  return geometry::voxel_at(blocks_[cell.block]->index, cell.offset);
}

bool SearchSpace::step(CellRef from, int move, CellRef* out) {
  const geometry::Index3& step = moves()[move].step;
  const int x = (from.offset & (kSide - 1)) + step.x;
  const int y = ((from.offset >> geometry::kBlockShift) & (kSide - 1)) + step.y;
  const int z = (from.offset >> (2 * geometry::kBlockShift)) + step.z;
  out->block = from.block;
  out->offset = static_cast<std::uint16_t>(geometry::offset_in_block({x, y, z}));
  const geometry::Index3 crossed{(x >> 4), (y >> 4), (z >> 4)};
  const int side = move_of(crossed);
  if (side == kNoMove) return true;
  std::int64_t number = blocks_[from.block]->neighbours[side];
  if (number == kUnresolved) {
    number = number_of(blocks_[from.block]->index + crossed);
    blocks_[from.block]->neighbours[side] = number;
  }
  if (number < 0) return false;
  out->block = static_cast<std::uint32_t>(number);
  return true;
}

}  // namespace voxnav::planning
