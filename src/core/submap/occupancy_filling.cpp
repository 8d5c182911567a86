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
    float along_x[kBlockSide];
    for (int x = 0; x < kBlockSide; ++x) along_x[x] = (static_cast<float>(x) - p.x()) * (static_cast<float>(x) - p.x());
    const int y1 = std::min(kBlockSide, leaf.y + reach + 1);
    const int z1 = std::min(kBlockSide, leaf.z + reach + 1);
    for (int z = std::max(0, leaf.z - reach); z < z1; ++z) {
      for (int y = std::max(0, leaf.y - reach); y < y1; ++y) {
        const float dy = static_cast<float>(y) - p.y();
        const float dz = static_cast<float>(z) - p.z();
        const float base = dy * dy + dz * dz;
        if (base > band2) continue;
        // Whole rows: a loop of fixed length is vectorised, which costs less than finding where the ball ends.
        float* row = &squared[static_cast<std::size_t>((y << 4) | (z << 8))];
        for (int x = 0; x < kBlockSide; ++x) row[x] = std::min(row[x], base + along_x[x]);
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

/// Squared distance in voxels to the nearest free voxel of the 26 around; 0 when none is free.
int squared_to_free_neighbor(const BlockWindow& window, const WindowLeaf& leaf) {
  int best = 0;
  for (int i = 0; i < 27; ++i) {
    const int dx = i % 3 - 1;
    const int dy = i / 3 % 3 - 1;
    const int dz = i / 9 - 1;
    const int squared = dx * dx + dy * dy + dz * dz;
    if (best > 0 && squared >= best) continue;
    if (window.state(leaf.x + dx, leaf.y + dy, leaf.z + dz) == State::kFree) best = squared;
  }
  return best;
}

bool is_enclosed(const BlockWindow& window, const WindowLeaf& leaf) {
  const auto is_occupied = [&](int dx, int dy, int dz) {
    return window.state(leaf.x + dx, leaf.y + dy, leaf.z + dz) == State::kOccupied;
  };
  return is_occupied(1, 0, 0) && is_occupied(-1, 0, 0) && is_occupied(0, 1, 0) && is_occupied(0, -1, 0) &&
         is_occupied(0, 0, 1) && is_occupied(0, 0, -1);
}

/// Gives the unknown voxels around a leaf the signed distance to its plane, where it is their nearest leaf.
void spread_ghosts(const BlockWindow& window, const WindowLeaf& leaf, std::vector<float>* nearest,
                   std::vector<float>* values) {
  for (int i = 0; i < 27; ++i) {
    const int x = leaf.x + i % 3 - 1;
    const int y = leaf.y + i / 3 % 3 - 1;
    const int z = leaf.z + i / 9 - 1;
    if (((x | y | z) & ~15) != 0 || window.state(x, y, z) != State::kUnknown) continue;
    const Vec3f from_surface = Vec3f(x - leaf.x, y - leaf.y, z - leaf.z) - leaf.mean();
    const float squared = from_surface.squaredNorm();
    const auto offset = static_cast<std::size_t>(x | (y << 4) | (z << 8));
    if (squared >= (*nearest)[offset]) continue;
    (*nearest)[offset] = squared;
    // Behind what has no free side at all is more of it; around a thin thing is outside.
    const bool is_one_sided = leaf.leaf->quality >= kSolidQuality;
    const bool is_deep = leaf.leaf->quality == 0.f;
    const float distance = std::sqrt(squared);
    (*values)[offset] = is_one_sided ? leaf.leaf->normal.dot(from_surface) : is_deep ? -distance : distance;
  }
}

/// Values of one block; the window has a halo wider than the band.
class BlockFiller {
 public:
  BlockFiller(const BlockWindow& window, float band) : window_(window), band_(band) {}

  std::vector<float> values() {
    std::vector<float> out(kBlockVolume, kNone);
    const std::vector<float> squared = splat(window_, band_);
    for (int offset = 0; offset < kBlockVolume; ++offset) {
      if (squared[offset] > band_ * band_) continue;
      if (window_.state(offset & 15, (offset >> 4) & 15, offset >> 8) == State::kFree)
        out[offset] = std::sqrt(squared[offset]);
    }
    std::vector<float> nearest(kBlockVolume, kFar);
    for (const WindowLeaf& leaf : window_.leaves()) {
      const bool is_near = std::min({leaf.x, leaf.y, leaf.z}) >= -1 && std::max({leaf.x, leaf.y, leaf.z}) <= kBlockSide;
      if (!is_near) continue;
      spread_ghosts(window_, leaf, &nearest, &out);
      if (((leaf.x | leaf.y | leaf.z) & ~15) == 0) out[leaf.leaf->offset] = inside_value(leaf);
    }
    return out;
  }

 private:
  float inside_value(const WindowLeaf& leaf) {
    constexpr float kDeepest = -0.1f;
    const float to_plane = -leaf.leaf->normal.dot(leaf.mean());
    if (leaf.leaf->quality >= kPlanarQuality) return to_plane;
    if (leaf.leaf->quality >= kOneSidedQuality) return std::min(to_plane, kDeepest);
    int squared = squared_to_free_neighbor(window_, leaf);
    // What lies in unknown space may be one voxel thick; only what is enclosed is known to be deep inside.
    if (squared == 0) squared = is_enclosed(window_, leaf) ? deep(leaf) : 1;
    return std::max(0.5f - std::sqrt(static_cast<float>(squared)), -band_);
  }

  int deep(const WindowLeaf& leaf) {
    const int halo = window_.halo();
    const int side = window_.side();
    if (to_free_.empty()) to_free_ = squared_to_free(window_, halo - 1);
    return to_free_[static_cast<std::size_t>(leaf.x + halo + side * (leaf.y + halo + side * (leaf.z + halo)))];
  }

  const BlockWindow& window_;
  float band_;
  std::vector<int> to_free_;
};

FilledBlock convert(const occupancy::ContentBlock& block) {
  FilledBlock out;
  out.index = block.index;
  out.states = block.states;
  out.leaves.reserve(block.occupied.size());
  std::size_t num_occupied = 0;
  for (const std::uint64_t word : block.states.words) {
    num_occupied += static_cast<std::size_t>(__builtin_popcountll(word & 0xAAAAAAAAAAAAAAAAull));
  }
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
