// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/end_voxels.hpp"

#include "voxnav/occupancy/byte_ops.hpp"

namespace voxnav::occupancy {

EndVoxels::EndVoxels(std::array<int, 3> num_blocks) : num_blocks_(num_blocks) {
  index_.assign(static_cast<std::size_t>(num_blocks[0]) * num_blocks[1] * num_blocks[2], -1);
}

void EndVoxels::clear() {
  for (const Block& block : blocks_) index_[block.slot] = -1;
  blocks_.clear();
  runs_.clear();
  hits_.clear();
  clearing_ends_.clear();
}

EndVoxels::Address EndVoxels::address_of(int x, int y, int z) {
  const int slot = (x >> 4) + num_blocks_[0] * ((y >> 4) + num_blocks_[1] * (z >> 4));
  std::int32_t block = index_[slot];
  if (block < 0) {
    block = static_cast<std::int32_t>(blocks_.size());
    index_[slot] = block;
    blocks_.emplace_back();
    blocks_.back().slot = static_cast<std::uint32_t>(slot);
  }
  return {static_cast<std::uint32_t>(block), static_cast<std::uint32_t>(geometry::offset_in_block({x, y, z}))};
}

inline void EndVoxels::Sum::add(const geometry::Vec3f& p) {
  offset += p;
  const float products[6] = {p[0] * p[0], p[0] * p[1], p[0] * p[2], p[1] * p[1], p[1] * p[2], p[2] * p[2]};
  for (int i = 0; i < 6; ++i) product[i] += products[i];
  ++count;
}

inline void EndVoxels::Sum::add(const Sum& other) {
  offset += other.offset;
  for (int i = 0; i < 6; ++i) product[i] += other.product[i];
  count += other.count;
}

void EndVoxels::add_hit(const geometry::Vec3f& end) {
  // Coordinates in the window are never negative, so truncation is floor.
  const geometry::Index3 voxel{static_cast<int>(end.x()), static_cast<int>(end.y()), static_cast<int>(end.z())};
  if (runs_.empty() || runs_.back().voxel != voxel) {
    const Address address = address_of(voxel.x, voxel.y, voxel.z);
    blocks_[address.block].hits[address.offset >> 6] |= std::uint64_t{1} << (address.offset & 63);
    runs_.push_back({voxel, address, {}});
  }
  const geometry::Vec3f center(static_cast<float>(voxel.x) + 0.5f, static_cast<float>(voxel.y) + 0.5f,
                               static_cast<float>(voxel.z) + 0.5f);
  runs_.back().sum.add(end - center);
}

void EndVoxels::add_clearing(const geometry::Vec3f& end) {
  const Address address = address_of(static_cast<int>(end.x()), static_cast<int>(end.y()), static_cast<int>(end.z()));
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
      in_block += static_cast<std::size_t>(__builtin_popcountll(block.hits[word]));
    }
    total += in_block;
  }
  return total;
}

PointSpread EndVoxels::spread_of(const Sum& sum) {
  PointSpread out;
  const float share = 1.0f / static_cast<float>(sum.count);
  out.mean = sum.offset * share;
  const float products[6] = {out.mean[0] * out.mean[0], out.mean[0] * out.mean[1], out.mean[0] * out.mean[2],
                             out.mean[1] * out.mean[1], out.mean[1] * out.mean[2], out.mean[2] * out.mean[2]};
  for (int i = 0; i < 6; ++i) out.covariance[i] = sum.product[i] * share - products[i];
  return out;
}

void EndVoxels::finish() {
  sums_.assign(count_hits(), Sum{});
  for (const EndRun& run : runs_) {
    const Block& block = blocks_[run.address.block];
    const std::uint32_t word = run.address.offset >> 6;
    const std::uint64_t below = (std::uint64_t{1} << (run.address.offset & 63)) - 1;
    const auto rank = static_cast<std::size_t>(__builtin_popcountll(block.hits[word] & below));
    sums_[block.first_hit + block.hits_before[word] + rank].add(run.sum);
  }
  hits_.reserve(sums_.size());
  for (const Block& block : blocks_) {
    for (int word = 0; word < 64; ++word) {
      for_each_bit(block.hits[word], [&](int bit) {
        hits_.push_back({block.slot, static_cast<std::uint16_t>(word * 64 + bit), spread_of(sums_[hits_.size()])});
      });
    }
  }
}

EndVoxels::Range EndVoxels::range(std::uint32_t slot) const {
  const std::int32_t i = index_[slot];
  if (i < 0) return {0, 0};
  const auto next = static_cast<std::size_t>(i) + 1;
  return {blocks_[i].first_hit, next < blocks_.size() ? blocks_[next].first_hit : hits_.size()};
}

geometry::Vec3f EndVoxels::center_of(const HitVoxel& hit) const {
  const int x = static_cast<int>(hit.slot) % num_blocks_[0];
  const int yz = static_cast<int>(hit.slot) / num_blocks_[0];
  const geometry::Index3 voxel = geometry::voxel_at({x, yz % num_blocks_[1], yz / num_blocks_[1]}, hit.offset);
  return geometry::Vec3f(static_cast<float>(voxel.x) + 0.5f, static_cast<float>(voxel.y) + 0.5f,
                         static_cast<float>(voxel.z) + 0.5f);
}

std::size_t EndVoxels::memory_bytes() const {
  return index_.capacity() * sizeof(index_[0]) + blocks_.capacity() * sizeof(Block) +
         runs_.capacity() * sizeof(EndRun) + sums_.capacity() * sizeof(Sum) + hits_.capacity() * sizeof(HitVoxel) +
         clearing_ends_.capacity() * sizeof(geometry::Vec3f);
}

}  // namespace voxnav::occupancy
