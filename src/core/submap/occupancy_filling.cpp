// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/occupancy_filling.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "voxnav/submap/block_window.hpp"

namespace voxnav::submap {
namespace {

using containers::State;
using geometry::kBlockSide;
using geometry::kBlockVolume;
using geometry::Vec3f;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr float kFar = std::numeric_limits<float>::infinity();

/// Squared distance of every voxel centre of the block to the nearest surface point within the band.
std::vector<float> splat(const BlockWindow& window, float band) {
  std::vector<float> squared(kBlockVolume, kFar);
  const int reach = static_cast<int>(std::ceil(band + 0.5f));
  const float band2 = band * band * 1.0001f;
  for (const WindowLeaf& leaf : window.leaves()) {
    const Vec3f p = Vec3f(leaf.x, leaf.y, leaf.z) + leaf.mean();
    const int x0 = std::max(0, leaf.x - reach);
    const int x1 = std::min(kBlockSide, leaf.x + reach + 1);
    const int y1 = std::min(kBlockSide, leaf.y + reach + 1);
    const int z1 = std::min(kBlockSide, leaf.z + reach + 1);
    for (int z = std::max(0, leaf.z - reach); z < z1; ++z) {
      for (int y = std::max(0, leaf.y - reach); y < y1; ++y) {
        const float dy = static_cast<float>(y) - p.y();
        const float dz = static_cast<float>(z) - p.z();
        const float base = dy * dy + dz * dz;
        if (base > band2) continue;
        float* row = &squared[static_cast<std::size_t>((y << 4) | (z << 8))];
        for (int x = x0; x < x1; ++x) {
          const float dx = static_cast<float>(x) - p.x();
          row[x] = std::min(row[x], base + dx * dx);
        }
      }
    }
  }
  return squared;
}

/// Squared distances (in voxels, up to `reach`) from every voxel of the block to the nearest free voxel.
/// Three passes of a windowed minimum with parabolas. Source: Felzenszwalb & Huttenlocher 2012, section 2.
std::vector<int> squared_to_free(const BlockWindow& window, int reach) {
  const int side = window.side();
  const int halo = window.halo();
  constexpr int kInfinite = 1 << 20;
  std::vector<int> from(static_cast<std::size_t>(side) * side * side);
  std::vector<int> to(from.size(), kInfinite);
  for (int z = 0; z < side; ++z) {
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const bool is_free = window.state(x - halo, y - halo, z - halo) == State::kFree;
        from[static_cast<std::size_t>(x + side * (y + side * z))] = is_free ? 0 : kInfinite;
      }
    }
  }
  const int strides[3] = {1, side, side * side};
  for (const int stride : strides) {
    std::fill(to.begin(), to.end(), kInfinite);
    const int size = static_cast<int>(from.size());
    for (int k = -reach; k <= reach; ++k) {
      // Rows wrap at the window's edge; the halo is wider than the reach, so the block itself never sees it.
      const int first = std::max(0, -k * stride);
      const int last = std::min(size, size - k * stride);
      for (int i = first; i < last; ++i) to[i] = std::min(to[i], from[i + k * stride] + k * k);
    }
    std::swap(from, to);
  }
  return from;
}

/// Nearest surface point among the 27 voxels around an unknown one gives its signed plane distance.
float ghost_value(const BlockWindow& window, int x, int y, int z) {
  float best = kFar;
  float value = kNone;
  for (int i = 0; i < 27; ++i) {
    const int index = window.leaf_at(x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1);
    if (index < 0) continue;
    const WindowLeaf& leaf = window.leaves()[index];
    const Vec3f from_surface = Vec3f(x - leaf.x, y - leaf.y, z - leaf.z) - leaf.mean();
    const float distance = from_surface.norm();
    if (distance >= best) continue;
    best = distance;
    // Behind what has no free side at all is more of it; around a thin thing is outside.
    const bool is_one_sided = leaf.leaf->quality >= kSolidQuality;
    const bool is_deep = leaf.leaf->quality == 0.f;
    value = is_one_sided ? leaf.leaf->normal.dot(from_surface) : is_deep ? -distance : distance;
  }
  return value;
}

/// Values of one block; the window has a halo wider than the band.
class BlockFiller {
 public:
  BlockFiller(const BlockWindow& window, float band)
      : window_(window), band_(band), squared_(splat(window, band)), reach_(window.halo()) {}

  std::vector<float> values() {
    std::vector<float> out(kBlockVolume, kNone);
    for (int offset = 0; offset < kBlockVolume; ++offset) {
      const int x = offset & 15;
      const int y = (offset >> 4) & 15;
      const int z = offset >> 8;
      switch (window_.state(x, y, z)) {
        case State::kFree:
          if (squared_[offset] < kFar) out[offset] = std::sqrt(squared_[offset]);
          break;
        case State::kOccupied:
          out[offset] = inside_value(x, y, z);
          break;
        case State::kUnknown:
          // A leaf in the 26-neighbourhood is nearer than this.
          if (squared_[offset] < 9.f) out[offset] = ghost_value(window_, x, y, z);
          break;
      }
    }
    return out;
  }

 private:
  float inside_value(int x, int y, int z) {
    constexpr float kDeepest = -0.1f;
    const WindowLeaf& leaf = window_.leaves()[window_.leaf_at(x, y, z)];
    const float to_plane = -leaf.leaf->normal.dot(leaf.mean());
    if (leaf.leaf->quality >= kPlanarQuality) return to_plane;
    if (leaf.leaf->quality >= kOneSidedQuality) return std::min(to_plane, kDeepest);
    if (to_free_.empty()) to_free_ = squared_to_free(window_, reach_ - 1);
    const int halo = window_.halo();
    const int side = window_.side();
    const int squared = to_free_[static_cast<std::size_t>(x + halo + side * (y + halo + side * (z + halo)))];
    return std::max(0.5f - std::sqrt(static_cast<float>(squared)), -band_);
  }

  const BlockWindow& window_;
  float band_;
  std::vector<float> squared_;
  int reach_;
  std::vector<int> to_free_;
};

FilledBlock convert(const occupancy::ContentBlock& block) {
  FilledBlock out;
  out.index = block.index;
  out.states = block.states;
  out.leaves.reserve(block.occupied.size());
  std::size_t num_occupied = 0;
  for (int offset = 0; offset < kBlockVolume; ++offset) num_occupied += block.states.get(offset) == State::kOccupied;
  int last = -1;
  for (const occupancy::OccupiedLeaf& leaf : block.occupied) {
    const bool fits =
        leaf.offset < kBlockVolume && leaf.offset > last && block.states.get(leaf.offset) == State::kOccupied;
    if (!fits) throw std::invalid_argument("map content has leaves that do not match its states");
    last = leaf.offset;
    FilledLeaf filled;
    filled.offset = leaf.offset;
    for (int k = 0; k < 3; ++k) filled.mean[k] = std::max<std::int8_t>(leaf.mean[k], -127);
    filled.hits = leaf.hits;
    out.leaves.push_back(filled);
  }
  if (num_occupied != block.occupied.size())
    throw std::invalid_argument("map content has leaves that do not match its states");
  return out;
}

}  // namespace

std::vector<FilledBlock> fill_from_occupancy(const occupancy::MapContent& content, const SubmapConfig& config) {
  std::vector<FilledBlock> blocks;
  blocks.reserve(content.blocks.size());
  for (const occupancy::ContentBlock& block : content.blocks) blocks.push_back(convert(block));
  const auto less = [](const FilledBlock& a, const FilledBlock& b) { return a.index < b.index; };
  std::sort(blocks.begin(), blocks.end(), less);
  estimate_normals(&blocks);
  const BlockIndex index(blocks);
  const int halo = static_cast<int>(std::ceil(config.band_voxels + 0.5));
  for (FilledBlock& block : blocks) {
    BlockWindow window(index, block.index, halo);
    if (window.leaves().empty()) continue;
    window.load_states();
    block.values = BlockFiller(window, static_cast<float>(config.band_voxels)).values();
  }
  return blocks;
}

}  // namespace voxnav::submap
