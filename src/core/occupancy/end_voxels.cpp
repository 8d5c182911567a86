// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/end_voxels.hpp"

#include <algorithm>

#include "kernels/bits.hpp"

namespace voxnav::occupancy {

EndVoxels::EndVoxels(std::array<int, 3> num_blocks) : num_blocks_(num_blocks) {
  index_.assign(static_cast<std::size_t>(num_blocks[0]) * num_blocks[1] * num_blocks[2], -1);
}

void EndVoxels::clear() {
  for (const Block& block : blocks_) index_[block.slot] = -1;
  blocks_.clear();
  parts_.clear();
  addresses_.clear();
  hits_.clear();
  clearing_ends_.clear();
  rays_.clear();
}

EndVoxels::Address EndVoxels::address_of(const geometry::Index3& v) {
  const int slot = (v.x >> 4) + num_blocks_[0] * ((v.y >> 4) + num_blocks_[1] * (v.z >> 4));
  std::int32_t block = index_[slot];
  if (block < 0) {
    block = static_cast<std::int32_t>(blocks_.size());
    index_[slot] = block;
    blocks_.emplace_back();
    blocks_.back().slot = static_cast<std::uint32_t>(slot);
  }
  return {static_cast<std::uint32_t>(block), static_cast<std::uint32_t>(geometry::offset_in_block(v))};
}

void EndVoxels::add(const ScanPart& part) {
  parts_.push_back(&part);
  for (const EndRun& run : part.runs()) {
    const Address address = address_of(run.voxel);
    blocks_[address.block].hits[address.offset >> 6] |= std::uint64_t{1} << (address.offset & 63);
    addresses_.push_back(address);
  }
  for (const geometry::Vec3f& end : part.clearing_ends()) add_clearing(end);
}

void EndVoxels::add_clearing(const geometry::Vec3f& end) {
  const Address address = address_of({static_cast<int>(end.x()), static_cast<int>(end.y()), static_cast<int>(end.z())});
  std::uint64_t& word = blocks_[address.block].clearing[address.offset >> 6];
  const std::uint64_t bit = std::uint64_t{1} << (address.offset & 63);
  if ((word & bit) == 0) clearing_ends_.push_back(end);
  word |= bit;
}

std::size_t EndVoxels::count_hits() {
  std::size_t total = 0;
  for (Block& block : blocks_) {
    block.first_hit = static_cast<std::uint32_t>(total);
    std::size_t in_block = 0;
    for (int word = 0; word < 64; ++word) {
      block.hits_before[word] = static_cast<std::uint16_t>(in_block);
      in_block += kernels::count_bits(block.hits[word]);
    }
    total += in_block;
  }
  return total;
}

PointSpread EndVoxels::spread_of(const kernels::PointSum& sum) {
  PointSpread out;
  const float share = 1.0f / sum.first[3];
  out.mean = geometry::Vec3f(sum.first[0], sum.first[1], sum.first[2]) * share;
  const geometry::Vec3f& m = out.mean;
  out.covariance = {sum.second[0] * share - m[0] * m[0], sum.second[1] * share - m[0] * m[1],
                    sum.second[2] * share - m[0] * m[2], sum.third[1] * share - m[1] * m[1],
                    sum.third[2] * share - m[1] * m[2],  sum.zz * share - m[2] * m[2]};
  return out;
}

void EndVoxels::finish() {
  sums_.assign(count_hits(), kernels::PointSum{});
  std::size_t next = 0;
  for (const ScanPart* part : parts_) {
    for (const EndRun& run : part->runs()) {
      const Address address = addresses_[next++];
      const Block& block = blocks_[address.block];
      const std::uint32_t word = address.offset >> 6;
      const std::uint64_t below = (std::uint64_t{1} << (address.offset & 63)) - 1;
      sums_[block.first_hit + block.hits_before[word] + kernels::count_bits(block.hits[word] & below)].add(run);
    }
  }
  hits_.reserve(sums_.size());
  // A vector that doubles its capacity could need up to 2 % of the memory of the whole map on top.
  rays_.reserve(sums_.size() + clearing_ends_.size());
  for (const Block& block : blocks_) finish_block(block);
  for (const geometry::Vec3f& end : clearing_ends_) rays_.push_back(end);
}

void EndVoxels::finish_block(const Block& block) {
  const geometry::Index3 at = block_of_slot(block.slot);
  for (int word = 0; word < 64; ++word) {
    kernels::for_each_bit(block.hits[word], [&](int bit) {
      const int offset = word * 64 + bit;
      const kernels::PointSum& sum = sums_[hits_.size()];
      const auto num_points = static_cast<std::uint16_t>(std::min(sum.first[3], 65535.0f));
      hits_.push_back({block.slot, static_cast<std::uint16_t>(offset), num_points, spread_of(sum)});
      const geometry::Index3 voxel = geometry::voxel_at(at, offset);
      const geometry::Vec3f corner(static_cast<float>(voxel.x), static_cast<float>(voxel.y),
                                   static_cast<float>(voxel.z));
      rays_.emplace_back(corner + geometry::Vec3f::Constant(0.5f) + hits_.back().points.mean);
    });
  }
}

EndVoxels::Range EndVoxels::range(std::uint32_t slot) const {
  const std::int32_t i = index_[slot];
  if (i < 0) return {0, 0};
  const auto next = static_cast<std::size_t>(i) + 1;
  return {blocks_[i].first_hit, next < blocks_.size() ? blocks_[next].first_hit : hits_.size()};
}

geometry::Index3 EndVoxels::block_of_slot(std::uint32_t slot) const {
  const int x = static_cast<int>(slot) % num_blocks_[0];
  const int yz = static_cast<int>(slot) / num_blocks_[0];
  return {x, yz % num_blocks_[1], yz / num_blocks_[1]};
}

void EndVoxels::widen(geometry::Index3* low, geometry::Index3* high) const {
  for (const Block& block : blocks_) {
    const geometry::Index3 at = block_of_slot(block.slot);
    *low = {std::min(low->x, at.x), std::min(low->y, at.y), std::min(low->z, at.z)};
    *high = {std::max(high->x, at.x), std::max(high->y, at.y), std::max(high->z, at.z)};
  }
}

std::size_t EndVoxels::memory_bytes() const {
  return index_.capacity() * sizeof(index_[0]) + blocks_.capacity() * sizeof(Block) +
         addresses_.capacity() * sizeof(Address) + sums_.capacity() * sizeof(kernels::PointSum) +
         hits_.capacity() * sizeof(HitVoxel) + clearing_ends_.capacity() * sizeof(geometry::Vec3f) +
         rays_.capacity() * sizeof(geometry::Vec3f);
}

}  // namespace voxnav::occupancy
