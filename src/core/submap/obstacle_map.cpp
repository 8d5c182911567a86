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

/// Sets every voxel whose centre is nearer than `reach` to p; all in voxel edges from the block's corner.
void add_ball(const Vec3& p, double reach, Mask* mask) {
  const double squared = reach * reach;
  const auto first = [&](double c) { return std::max(0, static_cast<int>(std::ceil(c - reach - 0.5))); };
  const auto last = [&](double c) { return std::min(kBlockSide - 1, static_cast<int>(std::floor(c + reach - 0.5))); };
  const int y1 = last(p.y());
  const int z1 = last(p.z());
  for (int z = first(p.z()); z <= z1; ++z) {
    const double dz = z + 0.5 - p.z();
    for (int y = first(p.y()); y <= y1; ++y) {
      const double dy = y + 0.5 - p.y();
      const double rest = squared - dy * dy - dz * dz;
      if (rest <= 0.0) continue;
      const double half = std::sqrt(rest);
      const int x0 = std::max(0, static_cast<int>(std::ceil(p.x() - half - 0.5)));
      const int x1 = std::min(kBlockSide - 1, static_cast<int>(std::floor(p.x() + half - 0.5)));
      if (x0 > x1) continue;
      (*mask)[static_cast<std::size_t>(y + kBlockSide * z)] |=
          static_cast<std::uint16_t>((0xFFFFu >> (kBlockSide - 1 - x1)) & (0xFFFFu << x0));
    }
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
        const Vec3 corner(x * kBlockSide, y * kBlockSide, z * kBlockSide);
        for (const EvidenceLeaf& leaf : near->leaves) {
          const Index3 local = geometry::voxel_at({0, 0, 0}, leaf.offset);
          const Vec3 mean(leaf.mean[0], leaf.mean[1], leaf.mean[2]);
          add_ball(corner + geometry::center_of(local, 1.0) + mean / 254.0, reach, &mask);
        }
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
