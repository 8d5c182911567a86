// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/octomap_nodes.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace voxnav::occupancy {
namespace {

using geometry::Index3;

constexpr int kBlocksReach = (1 << 15) / geometry::kBlockSide;  // blocks on each side of the origin of an OctoMap
constexpr int kUpperLevels = 12;                                // levels of an OctoMap above the roots of blocks
constexpr std::uint8_t kInner = 254;                            // stands for a node whose children differ

/// Zero unless the axis reaches beyond an OctoMap; then the block in the middle of the map.
std::int32_t shift_of(std::int32_t low, std::int32_t high, char axis) {
  if (low >= -kBlocksReach && high < kBlocksReach) return 0;
  const auto middle = static_cast<std::int32_t>((std::int64_t{low} + high) / 2);
  if (low - middle < -kBlocksReach || high - middle >= kBlocksReach) {
    throw std::length_error("the map is " + std::to_string((std::int64_t{high} - low + 1) * geometry::kBlockSide) +
                            " voxels wide along " + axis + ", and an OctoMap holds " +
                            std::to_string(2 * kBlocksReach * geometry::kBlockSide));
  }
  return middle;
}

Index3 shift_of(const std::vector<Index3>& blocks) {
  if (blocks.empty()) return {};
  Index3 low = blocks.front(), high = low;
  for (const Index3& block : blocks) {
    low = {std::min(low.x, block.x), std::min(low.y, block.y), std::min(low.z, block.z)};
    high = {std::max(high.x, block.x), std::max(high.y, block.y), std::max(high.z, block.z)};
  }
  return {shift_of(low.x, high.x, 'x'), shift_of(low.y, high.y, 'y'), shift_of(low.z, high.z, 'z')};
}

/// The bits of three coordinates, interleaved with x lowest: the order in which an OctoMap lists its children.
std::uint64_t morton_of(const Index3& key) {
  std::uint64_t out = 0;
  for (int bit = kUpperLevels - 1; bit >= 0; --bit) {
    const auto one = [bit](std::int32_t value) { return static_cast<std::uint64_t>((value >> bit) & 1); };
    out = out << 3 | one(key.z) << 2 | one(key.y) << 1 | one(key.x);
  }
  return out;
}

struct KeyedBlock {
  std::uint64_t morton;
  Index3 index;
};

std::vector<KeyedBlock> sorted(const std::vector<Index3>& blocks, const Index3& shift) {
  const Index3 origin = shift - Index3{kBlocksReach, kBlocksReach, kBlocksReach};
  std::vector<KeyedBlock> out;
  out.reserve(blocks.size());
  for (const Index3& block : blocks) out.push_back({morton_of(block - origin), block});
  std::sort(out.begin(), out.end(), [](const KeyedBlock& a, const KeyedBlock& b) { return a.morton < b.morton; });
  return out;
}

/// The octree of one block. A node is the code of all voxels below it if they are equal, else kInner.
class BlockTree {
 public:
  /// Reduces the codes of level 0, which were written to codes().
  void reduce() {
    for (int level = 1; level <= geometry::kBlockShift; ++level) reduce(level);
  }
  VoxelCodes& codes() { return voxels_; }
  std::uint8_t node(int level, int x, int y, int z) const {
    return level == 0 ? voxels_[at(0, x, y, z)] : nodes_[at(level, x, y, z)];
  }
  /// The highest code below a node.
  std::uint8_t highest(int level, int x, int y, int z) const {
    return level == 0 ? voxels_[at(0, x, y, z)] : highest_[at(level, x, y, z)];
  }

 private:
  static constexpr std::array<int, geometry::kBlockShift + 1> kFirst{0, 0, 512, 576, 584};
  static int at(int level, int x, int y, int z) {
    const int shift = geometry::kBlockShift - level;
    return kFirst[level] + x + (y << shift) + (z << (2 * shift));
  }

  void reduce(int level) {
    const int side = geometry::kBlockSide >> level;
    for (int z = 0; z < side; ++z) {
      for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) reduce(level, x, y, z);
      }
    }
  }

  void reduce(int level, int x, int y, int z) {
    const std::uint8_t first = node(level - 1, 2 * x, 2 * y, 2 * z);
    bool is_uniform = first != kInner;
    std::uint8_t most = kNoVoxel;
    for (int child = 0; child < 8; ++child) {
      const int cx = 2 * x + (child & 1), cy = 2 * y + (child >> 1 & 1), cz = 2 * z + (child >> 2);
      is_uniform = is_uniform && node(level - 1, cx, cy, cz) == first;
      const std::uint8_t code = highest(level - 1, cx, cy, cz);
      if (code != kNoVoxel && (most == kNoVoxel || code > most)) most = code;
    }
    nodes_[at(level, x, y, z)] = is_uniform ? first : kInner;
    highest_[at(level, x, y, z)] = most;
  }

  VoxelCodes voxels_;
  std::array<std::uint8_t, 585> nodes_, highest_;
};

/// A node that has been written: its code, or kInner, and the highest code below it.
struct Written {
  std::uint8_t code = kNoVoxel;
  std::uint8_t highest = kNoVoxel;
};

/// Writes nodes depth first. A node whose children turn out to be equal leaves takes their bytes back.
class NodeWriter {
 public:
  NodeWriter(const OctomapSource& source, OctomapForm form)
      : source_(source), is_full_(form == OctomapForm::kFull), header_bytes_(is_full_ ? sizeof(float) + 1 : 2) {}

  using Range = std::vector<KeyedBlock>::const_iterator;

  /// Writes the node over blocks [begin, end), whose codes differ in their lowest 3 * level bits only.
  Written write(Range begin, Range end, int level) {
    if (level == 0) {
      source_.read(begin->index, &tree_.codes());
      tree_.reduce();
      return write_block(geometry::kBlockShift, 0, 0, 0);
    }
    const Start start = begin_node();
    std::array<Written, 8> children;
    while (begin != end) {
      const unsigned child = begin->morton >> (3 * (level - 1)) & 7U;
      const Range last = std::find_if(
          begin, end, [=](const KeyedBlock& block) { return (block.morton >> (3 * (level - 1)) & 7U) != child; });
      children[child] = write(begin, last, level - 1);
      begin = last;
    }
    // OctoMap has no binary form of a root without children.
    return end_node(start, children, level < kUpperLevels);
  }

  std::string take() { return std::move(bytes_); }
  std::size_t num_nodes() const { return num_nodes_; }

 private:
  struct Start {
    std::size_t at, num_nodes;
  };

  Written write_block(int level, int x, int y, int z) {
    const std::uint8_t code = tree_.node(level, x, y, z);
    if (code != kInner) return write_leaf(code);
    const Start start = begin_node();
    std::array<Written, 8> children;
    for (int child = 0; child < 8; ++child) {
      children[child] = write_block(level - 1, 2 * x + (child & 1), 2 * y + (child >> 1 & 1), 2 * z + (child >> 2));
    }
    put_header(start.at, tree_.highest(level, x, y, z), children);
    return {kInner, tree_.highest(level, x, y, z)};
  }

  Written write_leaf(std::uint8_t code) {
    if (code == kNoVoxel) return {};
    ++num_nodes_;
    if (is_full_) {
      bytes_.append(header_bytes_, '\0');
      std::memcpy(&bytes_[bytes_.size() - header_bytes_], &source_.log_odds[code], sizeof(float));
    }
    return {code, code};
  }

  Start begin_node() {
    const Start start{bytes_.size(), num_nodes_};
    bytes_.append(header_bytes_, '\0');
    ++num_nodes_;
    return start;
  }

  Written end_node(const Start& start, const std::array<Written, 8>& children, bool may_be_leaf) {
    const std::uint8_t code = children[0].code;
    const auto is_same = [code](const Written& child) { return child.code == code; };
    if (code != kInner && may_be_leaf && std::all_of(children.begin(), children.end(), is_same)) {
      bytes_.resize(start.at);
      num_nodes_ = start.num_nodes;
      return write_leaf(code);
    }
    Written out{kInner, kNoVoxel};
    for (const Written& child : children) {
      if (child.highest == kNoVoxel) continue;
      out.highest = out.highest == kNoVoxel ? child.highest : std::max(out.highest, child.highest);
    }
    if (out.highest == kNoVoxel) {  // nothing is known below
      bytes_.resize(start.at);
      num_nodes_ = start.num_nodes;
      return {};
    }
    put_header(start.at, out.highest, children);
    return out;
  }

  void put_header(std::size_t at, std::uint8_t highest, const std::array<Written, 8>& children) {
    unsigned present = 0, kinds = 0;
    for (unsigned child = 0; child < 8; ++child) {
      const std::uint8_t code = children[child].code;
      if (code == kNoVoxel) continue;
      present |= 1U << child;
      kinds |= (code == kInner ? 3U : code == kOccupiedVoxel ? 2U : 1U) << (2 * child);
    }
    char* header = &bytes_[at];
    if (is_full_) {
      std::memcpy(header, &source_.log_odds[highest], sizeof(float));
      header[sizeof(float)] = static_cast<char>(present);
    } else {
      header[0] = static_cast<char>(kinds);
      header[1] = static_cast<char>(kinds >> 8);
    }
  }

  const OctomapSource& source_;
  bool is_full_;
  std::size_t header_bytes_;
  BlockTree tree_;
  std::string bytes_;
  std::size_t num_nodes_ = 0;
};

}  // namespace

OctomapNodes octomap_nodes(const OctomapSource& source, OctomapForm form) {
  OctomapNodes out;
  const Index3 shift = shift_of(source.blocks);
  out.shift = {shift.x * geometry::kBlockSide, shift.y * geometry::kBlockSide, shift.z * geometry::kBlockSide};
  const std::vector<KeyedBlock> blocks = sorted(source.blocks, shift);
  if (blocks.empty()) return out;
  NodeWriter writer(source, form);
  writer.write(blocks.begin(), blocks.end(), kUpperLevels);
  out.bytes = writer.take();
  out.num_nodes = writer.num_nodes();
  return out;
}

std::vector<std::int8_t> message_bytes(const OctomapNodes& nodes) {
  if (nodes.shift != Index3{}) {
    throw std::length_error(
        "the map lies farther than 2^15 voxels from the origin of its frame, beyond the reach of an "
        "OctoMap message; use an odometry frame with its origin nearby");
  }
  return std::vector<std::int8_t>(nodes.bytes.begin(), nodes.bytes.end());
}

}  // namespace voxnav::occupancy
