// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/new_voxels.hpp"

#include <algorithm>

namespace voxnav::occupancy {
namespace {

bool is_before(const NewVoxel& a, int offset) { return a.offset < offset; }

}  // namespace

std::size_t NewVoxels::add_hits(const HitVoxel* begin, const HitVoxel* end, const std::uint8_t* log_odds,
                                const StateLevels& levels, std::uint32_t scan) {
  std::size_t num_left_out = 0;
  const std::size_t num_known = voxels_.size();
  std::size_t known = 0;
  for (const HitVoxel* hit = begin; hit != end; ++hit) {
    while (known < num_known && voxels_[known].offset < hit->offset) ++known;
    if (known < num_known && voxels_[known].offset == hit->offset) {
      voxels_[known].last_scan = scan;
      voxels_[known].is_seen_through = false;
    } else if (log_odds[hit->offset] < levels.free_end()) {
      if (voxels_.size() < kMax) {
        voxels_.push_back({hit->offset, log_odds[hit->offset], false, false, false, scan, scan});
      } else {
        ++num_left_out;
      }
    }
  }
  const auto by_offset = [](const NewVoxel& a, const NewVoxel& b) { return a.offset < b.offset; };
  const auto added = voxels_.begin() + static_cast<std::ptrdiff_t>(num_known);
  if (added != voxels_.end()) std::inplace_merge(voxels_.begin(), added, voxels_.end(), by_offset);
  return num_left_out;
}

void NewVoxels::end_scan(const VoxelBits& seen_through, std::uint32_t scan) {
  const auto is_old = [&](NewVoxel& voxel) {
    if (((seen_through[voxel.offset >> 6] >> (voxel.offset & 63)) & 1u) != 0) voxel.is_seen_through = true;
    return !voxel.is_moving && scan - voxel.first_scan > kNewScans;
  };
  voxels_.erase(std::remove_if(voxels_.begin(), voxels_.end(), is_old), voxels_.end());
}

const NewVoxel* NewVoxels::find(int offset) const {
  const auto at = std::lower_bound(voxels_.begin(), voxels_.end(), offset, is_before);
  return at != voxels_.end() && at->offset == offset ? &*at : nullptr;
}

NewVoxel* NewVoxels::find(int offset) {
  const auto at = std::lower_bound(voxels_.begin(), voxels_.end(), offset, is_before);
  return at != voxels_.end() && at->offset == offset ? &*at : nullptr;
}

bool NewVoxels::add(const NewVoxel& voxel) {
  if (voxels_.size() >= kMax) return false;
  voxels_.insert(std::lower_bound(voxels_.begin(), voxels_.end(), voxel.offset, is_before), voxel);
  return true;
}

void NewVoxels::erase(int offset) {
  const auto at = std::lower_bound(voxels_.begin(), voxels_.end(), offset, is_before);
  if (at != voxels_.end() && at->offset == offset) voxels_.erase(at);
}

}  // namespace voxnav::occupancy
