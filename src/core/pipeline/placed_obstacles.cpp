// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/placed_obstacles.hpp"

#include <cmath>

namespace voxnav::pipeline {

using containers::StateBlock;
using containers::VoxelState;
using geometry::Index3;
using geometry::Vec3;
using planning::BlockMask;

namespace {

constexpr int kSide = geometry::kBlockSide;

/// The blocks of a grid within a box of blocks, found once instead of for each voxel.
class NearBlocks {
 public:
  NearBlocks(const containers::StateGrid& grid, const geometry::Aabb& box) {
    const double side = kSide * grid.resolution_m();
    low_ = geometry::index_of(box.min, side);
    const Index3 size = geometry::index_of(box.max, side) - low_ + Index3{1, 1, 1};
    size_ = size;
    blocks_.reserve(static_cast<std::size_t>(size.x) * size.y * size.z);
    for (int z = 0; z < size.z; ++z) {
      for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) blocks_.push_back(grid.find_block(low_ + Index3{x, y, z}));
      }
    }
  }

  bool empty() const {
    for (const StateBlock* block : blocks_) {
      if (block != nullptr) return false;
    }
    return true;
  }

  bool is_occupied(const Index3& voxel) const {
    const Index3 at = geometry::block_of(voxel) - low_;
    // Rounding may lead a voxel's centre just out of the box around all of them.
    if (at.x < 0 || at.y < 0 || at.z < 0 || at.x >= size_.x || at.y >= size_.y || at.z >= size_.z) return false;
    const std::ptrdiff_t row = at.y + std::ptrdiff_t{size_.y} * at.z;
    const StateBlock* block = blocks_[static_cast<std::size_t>(at.x + size_.x * row)];
    return block != nullptr && block->get(geometry::offset_in_block(voxel)) == VoxelState::kOccupied;
  }

 private:
  Index3 low_{0, 0, 0};
  Index3 size_{0, 0, 0};
  std::vector<const StateBlock*> blocks_;
};

}  // namespace

std::unique_ptr<BlockMask> PlacedObstacles::place(const Index3& block) const {
  const double side = kSide * resolution_m_;
  const Vec3 corner_O = Vec3(block.x, block.y, block.z) * side;
  const geometry::Aabb box_O{corner_O, corner_O + Vec3::Constant(side)};
  const NearBlocks near(*grid_, box_O.transformed(T_W_O_));
  if (near.empty()) return nullptr;
  // Positions in edges of the obstacles' voxels: the first centre, and the steps from one voxel in O to the next.
  const Eigen::Matrix3d step = T_W_O_.linear() * (resolution_m_ / grid_->resolution_m());
  const Vec3 first = T_W_O_ * (corner_O + Vec3::Constant(0.5 * resolution_m_)) / grid_->resolution_m();
  auto out = std::make_unique<BlockMask>();
  for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
    const Index3 in = geometry::voxel_at({0, 0, 0}, offset);
    const Vec3 p = first + step.col(0) * in.x + step.col(1) * in.y + step.col(2) * in.z;
    if (near.is_occupied(geometry::index_of(p, 1.0))) out->set(static_cast<std::size_t>(offset));
  }
  return out->any() ? std::move(out) : nullptr;
}

bool PlacedObstacles::mask(const Index3& block, BlockMask* out) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto [it, is_new] = masks_.try_emplace(block, nullptr);
  if (is_new) it->second = place(block);
  if (it->second == nullptr) return false;
  *out |= *it->second;
  return true;
}

std::vector<geometry::Aabb> PlacedObstacles::block_boxes() const {
  std::vector<geometry::Aabb> out;
  const double side = kSide * grid_->resolution_m();
  const geometry::Pose T_O_W = T_W_O_.inverse();
  for (const Index3& block : grid_->sorted_block_indices()) {
    const Vec3 corner = Vec3(block.x, block.y, block.z) * side;
    out.push_back(geometry::Aabb{corner, corner + Vec3::Constant(side)}.transformed(T_O_W));
  }
  return out;
}

}  // namespace voxnav::pipeline
