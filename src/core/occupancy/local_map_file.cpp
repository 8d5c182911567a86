// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "base/bytes.hpp"
#include "kernels/bits.hpp"
#include "occupancy/local_map_impl.hpp"

namespace voxnav::occupancy {
namespace {

constexpr base::Format kFormat{0x4D4C5856, 1, "a voxnav local map"};  // "VXLM"

static_assert(sizeof(SurfaceLeaf) == 32, "leaves are written as they are");

void put_config(const LocalMapConfig& config, base::ByteWriter* out) {
  LocalMapConfig::fields(
      [&](const char*, auto member, const base::Rule&, const char*, const char*) { out->put(config.*member); });
}

LocalMapConfig get_config(base::ByteReader* in) {
  LocalMapConfig config;
  LocalMapConfig::fields([&](const char*, auto member, const base::Rule&, const char*, const char*) {
    config.*member = in->get<std::decay_t<decltype(config.*member)>>();
  });
  const auto problems = base::problems_of(config);
  if (!problems.empty()) in->fail("has an unusable configuration: " + problems.front());
  return config;
}

void put_block(const OctreeBlock& block, base::ByteWriter* out) {
  out->put(block.log_odds);
  out->put(block.seen);
  out->put(block.leaves.bits());
  for (int word = 0; word < 64; ++word) {
    kernels::for_each_bit(block.leaves.bits()[word], [&](int bit) { out->put(*block.leaves.find(64 * word + bit)); });
  }
}

void get_block(OctreeBlock* block, const LogOddsScale& scale, base::ByteReader* in) {
  block->log_odds = in->get<decltype(block->log_odds)>();
  for (const std::uint8_t level : block->log_odds) {
    if (level > scale.max) in->fail("has a voxel beyond the clamp");
  }
  block->seen = in->get<VoxelBits>();
  block->leaves.assign(in->get<VoxelBits>());
  for (int word = 0; word < 64; ++word) {
    kernels::for_each_bit(block->leaves.bits()[word],
                          [&](int bit) { in->get_raw(block->leaves.find(64 * word + bit), sizeof(SurfaceLeaf)); });
  }
}

}  // namespace

std::string LocalMap::to_bytes() const {
  const OctreeForest& forest = impl_->forest;
  base::ByteWriter out;
  out.put_header(kFormat);
  put_config(impl_->config, &out);
  out.put(forest.window.is_placed());
  out.put(forest.window.first_block());
  out.put<std::int32_t>(forest.recent_scans);
  std::uint64_t count = 0;
  for (int slot = 0; slot < forest.window.num_slots(); ++slot) count += forest.window.at(slot) != nullptr ? 1 : 0;
  out.put(count);
  for (int slot = 0; slot < forest.window.num_slots(); ++slot) {
    if (forest.window.at(slot) == nullptr) continue;
    out.put<std::int32_t>(slot);
    put_block(*forest.window.at(slot), &out);
  }
  return out.finish();
}

LocalMap LocalMap::from_bytes(const std::string& bytes) {
  base::ByteReader in(bytes, "local map");
  in.check_header(kFormat);
  LocalMap map(get_config(&in));
  OctreeForest& forest = map.impl_->forest;
  forest.sequence = 1;
  const bool is_placed = in.get<std::uint8_t>() != 0;
  const auto first = in.get<geometry::Index3>();
  if (is_placed) forest.window.place(first);
  forest.recent_scans = in.get<std::int32_t>();
  if (forest.recent_scans < 0 || forest.recent_scans > SurfaceLeaf::kMaxNumber)
    in.fail("has an impossible number of scans");
  const std::uint64_t count = in.get_count(geometry::kBlockVolume);
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto slot = in.get<std::int32_t>();
    if (!is_placed || slot < 0 || slot >= forest.window.num_slots()) in.fail("has a block outside its window");
    OctreeBlock& block = forest.window.ensure(slot, forest.scale.prior);
    get_block(&block, forest.scale, &in);
    forest.refresh(slot);
  }
  return map;
}

void LocalMap::save(const std::string& path) const {
  const std::string bytes = to_bytes();
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) throw std::runtime_error("cannot write " + path);
}

LocalMap LocalMap::load(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path);
  const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  try {
    return from_bytes(bytes);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(path + ": " + error.what());
  }
}

}  // namespace voxnav::occupancy
