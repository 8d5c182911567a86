// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/obstacle_map.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace voxnav::submap {
namespace {

using containers::State;
using geometry::Index3;
using geometry::kBlockSide;
using geometry::Vec3;

double checked_resolution(double resolution_m, double safety_distance_m) {
  if (!(resolution_m > 0.0)) throw std::invalid_argument("resolution_m must be positive");
  if (!(safety_distance_m >= 0.0 && safety_distance_m <= 10.0)) {
    throw std::invalid_argument("safety_distance_m must be from 0 to 10");
  }
  return resolution_m;
}

/// One bit per voxel of a block, a 16-bit word per row along x.
using Mask = std::array<std::uint16_t, kBlockSide * kBlockSide>;

int floor_of(double c) {
  const int i = static_cast<int>(c);
  return i - static_cast<int>(c < i);
}
/// First and last voxel of the block whose centre lies in [low, high].
int first_center(double low) { return std::max(0, -floor_of(0.5 - low)); }
int last_center(double high) { return std::min(kBlockSide - 1, floor_of(high - 0.5)); }

/// Sets every voxel whose centre is nearer than `reach` to p; all in voxel edges from the block's corner.
void add_ball(const Vec3& p, double reach, Mask* mask) {
  const double squared = reach * reach;
  const int y1 = last_center(p.y() + reach);
  const int z1 = last_center(p.z() + reach);
  for (int z = first_center(p.z() - reach); z <= z1; ++z) {
    const double dz = z + 0.5 - p.z();
    for (int y = first_center(p.y() - reach); y <= y1; ++y) {
      const double dy = y + 0.5 - p.y();
      const double rest = squared - dy * dy - dz * dz;
      if (rest <= 0.0) continue;
      const double half = std::sqrt(rest);
      const int x0 = first_center(p.x() - half);
      const int x1 = last_center(p.x() + half);
      if (x0 > x1) continue;
      (*mask)[static_cast<std::size_t>(y + kBlockSide * z)] |=
          static_cast<std::uint16_t>((0xFFFFu >> (kBlockSide - 1 - x1)) & (0xFFFFu << x0));
    }
  }
}

/// Adds the leaves of one block whose corner lies at `corner` seen from the block of the mask.
void add_leaves(const EvidenceBlock& block, const Index3& corner, double reach, Mask* mask) {
  const double high = kBlockSide + reach;
  for (const EvidenceLeaf& leaf : block.leaves) {
    const double x = corner.x + (leaf.offset & 15) + 0.5 + leaf.mean[0] / 254.0;
    if (x < -reach || x > high) continue;
    const double y = corner.y + ((leaf.offset >> 4) & 15) + 0.5 + leaf.mean[1] / 254.0;
    if (y < -reach || y > high) continue;
    const double z = corner.z + (leaf.offset >> 8) + 0.5 + leaf.mean[2] / 254.0;
    if (z < -reach || z > high) continue;
    add_ball({x, y, z}, reach, mask);
  }
}

}  // namespace

ObstacleMap::ObstacleMap(double resolution_m, double safety_distance_m)
    : safety_distance_m_(safety_distance_m),
      reach_m_(safety_distance_m + 0.5 * std::sqrt(3.0) * checked_resolution(resolution_m, safety_distance_m)),
      reach_blocks_(static_cast<int>(std::ceil(reach_m_ / (resolution_m * kBlockSide)))),
      grid_(resolution_m) {}

void ObstacleMap::mark_changed(const std::vector<Index3>& blocks) {
  for (const Index3& block : blocks) {
    for (int z = -reach_blocks_; z <= reach_blocks_; ++z) {
      for (int y = -reach_blocks_; y <= reach_blocks_; ++y) {
        for (int x = -reach_blocks_; x <= reach_blocks_; ++x) due_.insert(block + Index3{x, y, z});
      }
    }
  }
}

std::size_t ObstacleMap::update(const EvidenceMap& evidence, std::size_t max_blocks) {
  for (std::size_t done = 0; done < max_blocks && !due_.empty(); ++done) {
    const Index3 index = *due_.begin();
    due_.erase(due_.begin());
    const containers::StateBlock block = compute(index, evidence);
    const containers::StateBlock* old = grid_.find_block(index);
    const bool is_same = old ? old->words == block.words : block.all_unknown();
    if (is_same) continue;
    grid_.replace_block(index, block);
    changed_.insert(index);
  }
  return due_.size();
}

containers::StateBlock ObstacleMap::compute(const Index3& index, const EvidenceMap& evidence) const {
  Mask mask{};
  const double reach = reach_m_ / grid_.resolution_m();
  for (int z = -reach_blocks_; z <= reach_blocks_; ++z) {
    for (int y = -reach_blocks_; y <= reach_blocks_; ++y) {
      for (int x = -reach_blocks_; x <= reach_blocks_; ++x) {
        const EvidenceBlock* near = evidence.find(index + Index3{x, y, z});
        if (!near) continue;
        add_leaves(*near, {x * kBlockSide, y * kBlockSide, z * kBlockSide}, reach, &mask);
      }
    }
  }
  containers::StateBlock out;
  const EvidenceBlock* known = evidence.find(index);
  if (known) out = known->states;
  for (int row = 0; row < kBlockSide * kBlockSide; ++row) {
    for (unsigned bits = mask[static_cast<std::size_t>(row)]; bits != 0; bits &= bits - 1) {
      out.set(row * kBlockSide + __builtin_ctz(bits), State::kOccupied);
    }
  }
  return out;
}

containers::GridUpdate ObstacleMap::take_changes() {
  const std::vector<Index3> blocks(changed_.begin(), changed_.end());
  changed_.clear();
  return containers::changes_of(grid_, blocks);
}

}  // namespace voxnav::submap
