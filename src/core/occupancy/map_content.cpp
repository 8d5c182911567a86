// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/map_content.hpp"

#include <algorithm>
#include <stdexcept>

#include "base/bytes.hpp"

namespace voxnav::occupancy {
namespace {

using containers::VoxelState;

constexpr base::Format kFormat{0x434D5856, 1, "a voxnav map content"};  // "VXMC"

/// Merges two contents of one block voxel by voxel: where `newer` knows a voxel, it wins. O(16^3).
ContentBlock merge_blocks(const ContentBlock& older, const ContentBlock& newer) {
  ContentBlock out;
  out.index = older.index;
  auto old_voxel = older.occupied.begin();
  auto new_voxel = newer.occupied.begin();
  for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
    const VoxelState newest = newer.states.get(offset);
    const VoxelState state = newest == VoxelState::kUnknown ? older.states.get(offset) : newest;
    out.states.set(offset, state);
    while (old_voxel != older.occupied.end() && old_voxel->offset < offset) ++old_voxel;
    while (new_voxel != newer.occupied.end() && new_voxel->offset < offset) ++new_voxel;
    if (state == VoxelState::kOccupied)
      out.occupied.push_back(newest == VoxelState::kUnknown ? *old_voxel : *new_voxel);
    const VoxelBits& observed_free = newest == VoxelState::kUnknown ? older.observed_free : newer.observed_free;
    out.observed_free[offset >> 6] |= observed_free[offset >> 6] & (std::uint64_t{1} << (offset & 63));
  }
  return out;
}

void put_voxel(const OccupiedVoxel& voxel, base::ByteWriter* out) {
  out->put(voxel.offset);
  out->put(voxel.believed);
  out->put(voxel.observed.hits);
  if (voxel.observed.hits == 0) return;
  out->put(voxel.observed.mean);
  out->put(voxel.observed_time);
}

OccupiedVoxel get_voxel(base::ByteReader* in) {
  OccupiedVoxel voxel;
  voxel.offset = in->get<std::uint16_t>();
  voxel.believed = in->get<VoxelPoint>();
  voxel.observed.hits = in->get<std::uint8_t>();
  if (voxel.observed.hits == 0) return voxel;
  voxel.observed.mean = in->get<std::array<std::int8_t, 3>>();
  voxel.observed_time = in->get<std::uint8_t>();
  return voxel;
}

/// Writes a bit set: first a word that tells which of the 64 words are not zero, then those words.
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
    out[offset >> 6] |= std::uint64_t{states.get(offset) == VoxelState::kFree} << (offset & 63);
  }
  return out;
}

void check_voxels(const ContentBlock& block, const base::ByteReader& reader) {
  std::size_t next = 0;
  for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
    const VoxelState state = block.states.get(offset);
    if (state > VoxelState::kOccupied) reader.fail("holds a voxel state that does not exist");
    if (state != VoxelState::kOccupied) continue;
    if (next >= block.occupied.size() || block.occupied[next++].offset != offset)
      reader.fail("has occupied voxels that do not match its states");
  }
  if (next != block.occupied.size()) reader.fail("has occupied voxels that do not match its states");
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
  for (const ContentBlock& block : blocks) bytes += block.occupied.capacity() * sizeof(OccupiedVoxel);
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
    for (const OccupiedVoxel& voxel : block.occupied) put_voxel(voxel, &out);
    put_bits(block.observed_free, &out);
  }
  return out.finish();
}

MapContent MapContent::from_bytes(const std::string& bytes) {
  base::ByteReader in(bytes, "map content");
  in.check_header(kFormat);
  MapContent out;
  out.resolution_m = in.get<double>();
  if (!(out.resolution_m > 0.0)) in.fail("has no positive resolution");
  constexpr std::size_t kVoxelBytes = 6;
  const auto num_blocks =
      in.get_count(sizeof(geometry::Index3) + sizeof(containers::StateBlock) + sizeof(std::uint64_t));
  out.blocks.resize(num_blocks);
  for (ContentBlock& block : out.blocks) {
    block.index = in.get<geometry::Index3>();
    block.states = in.get<containers::StateBlock>();
    block.occupied.resize(in.get_count(kVoxelBytes));
    for (OccupiedVoxel& voxel : block.occupied) voxel = get_voxel(&in);
    check_voxels(block, in);
    block.observed_free = get_bits(&in);
    const VoxelBits free = free_bits(block.states);
    for (std::size_t word = 0; word < free.size(); ++word) {
      if ((block.observed_free[word] & ~free[word]) != 0) in.fail("has observed free space that is not free");
    }
  }
  const auto less = [](const ContentBlock& a, const ContentBlock& b) { return a.index < b.index; };
  if (!std::is_sorted(out.blocks.begin(), out.blocks.end(), less)) in.fail("has unsorted blocks");
  return out;
}

geometry::Vec3f surface_point(const geometry::Index3& block, const OccupiedVoxel& voxel, double resolution_m) {
  const std::array<std::int8_t, 3>& mean = voxel.believed.mean;
  const geometry::Vec3 center = geometry::center_of(geometry::voxel_at(block, voxel.offset), resolution_m);
  return (center + geometry::Vec3(mean[0], mean[1], mean[2]) * (resolution_m / 254.0)).cast<float>();
}

}  // namespace voxnav::occupancy
