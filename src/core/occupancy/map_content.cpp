// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/map_content.hpp"

#include <algorithm>
#include <stdexcept>

#include "base/bytes.hpp"

namespace voxnav::occupancy {
namespace {

using containers::State;

constexpr base::Format kFormat{0x434D5856, 1, "a voxnav map content"};  // "VXMC"

/// Voxel by voxel: what `newer` knows wins. O(16^3).
ContentBlock merge_blocks(const ContentBlock& older, const ContentBlock& newer) {
  ContentBlock out;
  out.index = older.index;
  auto old_leaf = older.occupied.begin();
  auto new_leaf = newer.occupied.begin();
  for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
    const State newest = newer.states.get(offset);
    const State state = newest == State::kUnknown ? older.states.get(offset) : newest;
    out.states.set(offset, state);
    while (old_leaf != older.occupied.end() && old_leaf->offset < offset) ++old_leaf;
    while (new_leaf != newer.occupied.end() && new_leaf->offset < offset) ++new_leaf;
    if (state == State::kOccupied) out.occupied.push_back(newest == State::kUnknown ? *old_leaf : *new_leaf);
    const VoxelBits& own_free = newest == State::kUnknown ? older.own_free : newer.own_free;
    out.own_free[offset >> 6] |= own_free[offset >> 6] & (std::uint64_t{1} << (offset & 63));
  }
  return out;
}

void put_leaf(const OccupiedLeaf& leaf, base::ByteWriter* out) {
  out->put(leaf.offset);
  out->put(leaf.mean);
  out->put(leaf.hits);
  out->put(leaf.own_hits);
  if (leaf.own_hits == 0) return;
  out->put(leaf.own_mean);
  out->put(leaf.own_time);
}

OccupiedLeaf get_leaf(base::ByteReader* in) {
  OccupiedLeaf leaf;
  leaf.offset = in->get<std::uint16_t>();
  leaf.mean = in->get<std::array<std::int8_t, 3>>();
  leaf.hits = in->get<std::uint8_t>();
  leaf.own_hits = in->get<std::uint8_t>();
  if (leaf.own_hits == 0) return leaf;
  leaf.own_mean = in->get<std::array<std::int8_t, 3>>();
  leaf.own_time = in->get<std::uint8_t>();
  return leaf;
}

/// Which words have bits, and these.
void put_bits(const VoxelBits& bits, base::ByteWriter* out) {
  std::uint64_t used = 0;
  for (std::size_t word = 0; word < bits.size(); ++word) used |= std::uint64_t{bits[word] != 0} << word;
  out->put(used);
  for (const std::uint64_t word : bits) {
    if (word != 0) out->put(word);
  }
}

VoxelBits get_bits(base::ByteReader* in) {
  VoxelBits out{};
  const auto used = in->get<std::uint64_t>();
  for (std::size_t word = 0; word < out.size(); ++word) {
    if ((used >> word) & 1u) out[word] = in->get<std::uint64_t>();
  }
  return out;
}

VoxelBits free_bits(const containers::StateBlock& states) {
  VoxelBits out{};
  for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
    out[offset >> 6] |= std::uint64_t{states.get(offset) == State::kFree} << (offset & 63);
  }
  return out;
}

void check_leaves(const ContentBlock& block, const base::ByteReader& reader) {
  std::size_t next = 0;
  for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
    const State state = block.states.get(offset);
    if (state > State::kOccupied) reader.fail("holds a voxel state that does not exist");
    if (state != State::kOccupied) continue;
    if (next >= block.occupied.size() || block.occupied[next++].offset != offset)
      reader.fail("has leaves that do not match its states");
  }
  if (next != block.occupied.size()) reader.fail("has leaves that do not match its states");
}

}  // namespace

void MapContent::merge(const MapContent& newer) {
  if (blocks.empty() && resolution_m == 0.0) {
    *this = newer;
    return;
  }
  if (newer.resolution_m != resolution_m)
    throw std::invalid_argument("cannot merge map contents of different resolutions");
  std::vector<ContentBlock> merged;
  merged.reserve(blocks.size() + newer.blocks.size());
  auto a = blocks.begin();
  auto b = newer.blocks.begin();
  while (a != blocks.end() || b != newer.blocks.end()) {
    if (b == newer.blocks.end() || (a != blocks.end() && a->index < b->index)) {
      merged.push_back(std::move(*a++));
    } else if (a == blocks.end() || b->index < a->index) {
      merged.push_back(*b++);
    } else {
      merged.push_back(merge_blocks(*a++, *b++));
    }
  }
  blocks = std::move(merged);
}

std::size_t MapContent::num_occupied() const {
  std::size_t count = 0;
  for (const ContentBlock& block : blocks) count += block.occupied.size();
  return count;
}

std::size_t MapContent::memory_bytes() const {
  std::size_t bytes = sizeof(*this) + blocks.capacity() * sizeof(ContentBlock);
  for (const ContentBlock& block : blocks) bytes += block.occupied.capacity() * sizeof(OccupiedLeaf);
  return bytes;
}

std::string MapContent::to_bytes() const {
  base::ByteWriter out;
  out.put_header(kFormat);
  out.put(resolution_m);
  out.put<std::uint64_t>(blocks.size());
  for (const ContentBlock& block : blocks) {
    out.put(block.index);
    out.put(block.states);
    out.put<std::uint64_t>(block.occupied.size());
    for (const OccupiedLeaf& leaf : block.occupied) put_leaf(leaf, &out);
    put_bits(block.own_free, &out);
  }
  return out.finish();
}

MapContent MapContent::from_bytes(const std::string& bytes) {
  base::ByteReader in(bytes, "map content");
  in.check_header(kFormat);
  MapContent out;
  out.resolution_m = in.get<double>();
  if (!(out.resolution_m > 0.0)) in.fail("has no positive resolution");
  constexpr std::size_t kLeafBytes = 6;
  const auto num_blocks =
      in.get_count(sizeof(geometry::Index3) + sizeof(containers::StateBlock) + sizeof(std::uint64_t));
  out.blocks.resize(num_blocks);
  for (ContentBlock& block : out.blocks) {
    block.index = in.get<geometry::Index3>();
    block.states = in.get<containers::StateBlock>();
    block.occupied.resize(in.get_count(kLeafBytes));
    for (OccupiedLeaf& leaf : block.occupied) leaf = get_leaf(&in);
    check_leaves(block, in);
    block.own_free = get_bits(&in);
    const VoxelBits free = free_bits(block.states);
    for (std::size_t word = 0; word < free.size(); ++word) {
      if ((block.own_free[word] & ~free[word]) != 0) in.fail("has own free space that is not free");
    }
  }
  const auto less = [](const ContentBlock& a, const ContentBlock& b) { return a.index < b.index; };
  if (!std::is_sorted(out.blocks.begin(), out.blocks.end(), less)) in.fail("has unsorted blocks");
  return out;
}

geometry::Vec3f surface_point(const geometry::Index3& block, const OccupiedLeaf& leaf, double resolution_m) {
  const geometry::Vec3 mean(leaf.mean[0], leaf.mean[1], leaf.mean[2]);
  const geometry::Vec3 center = geometry::center_of(geometry::voxel_at(block, leaf.offset), resolution_m);
  return (center + mean * (resolution_m / 254.0)).cast<float>();
}

}  // namespace voxnav::occupancy
