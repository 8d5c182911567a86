// SPDX-License-Identifier: BSD-3-Clause
#include "submap/distance/distance_block.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "submap/content/field_window.hpp"

namespace voxnav::submap {
namespace {

using containers::State;
using geometry::Index3;
using geometry::kBlockSide;
using geometry::Vec3f;

constexpr float kFar = std::numeric_limits<float>::infinity();
constexpr int kHalo = FieldWindow::kHalo;
constexpr int kSide = DistanceBlock::kSide;
constexpr std::uint32_t kTable = ((1u << kSide) - 1) << (kHalo - 1);  // of a row of the window: what the block keeps

std::size_t at(int x, int y, int z) { return static_cast<std::size_t>((x + 1) + kSide * ((y + 1) + kSide * (z + 1))); }

/// A number for every voxel of the table.
using TableFloats = kernels::SquaredDistances;

/// Derives one block; keeps its memory for the next one.
class Deriver {
 public:
  std::shared_ptr<const DistanceBlock> derive(const CompressedField& field, const Index3& block) {
    band_ = static_cast<float>(field.band());
    window_.load(field, block, static_cast<int>(band_ + 1.5f));
    if (window_.leaves().empty()) return nullptr;
    auto out = std::make_shared<DistanceBlock>(field.band());
    out->measure_free(window_.view(), band_, &squared_);
    list_unknown();
    find_ghosts();
    estimate_normals(window_, near_, &normals_);
    for (std::size_t i = 0; i < near_.size(); ++i) {
      const WindowLeaf& leaf = window_.leaves()[near_[i]];
      if (is_in_table(leaf)) out->set(leaf.x, leaf.y, leaf.z, inside_value(leaf, normals_[i]));
    }
    take_ghosts(out.get());
    return out;
  }

 private:
  static constexpr int kFarAway = 1 << 10;
  /// Whether a leaf lies in the table, or at most so far beside it.
  static bool is_in_table(const WindowLeaf& leaf, int beside = 0) {
    const auto is_in = [&](int c) {
      return static_cast<unsigned>(c + 1 + beside) < kSide + 2u * static_cast<unsigned>(beside);
    };
    return is_in(leaf.x) & is_in(leaf.y) & is_in(leaf.z);
  }
  /// Of the row at (y, z) of the table and two around it on every side, so that no neighbour of a leaf is beyond.
  static std::size_t row_at(int y, int z) { return static_cast<std::size_t>((y + 3) + (kSide + 4) * (z + 3)); }

  void list_unknown() {
    unknown_.fill(0);
    for (int z = -1; z <= kBlockSide; ++z) {
      for (int y = -1; y <= kBlockSide; ++y) {
        unknown_[row_at(y, z)] = kTable & ~(window_.free(y, z) | window_.occupied(y, z));
      }
    }
  }

  /// The leaves whose planes reach into the table, and the nearest one of each unknown voxel that has one beside it.
  void find_ghosts() {
    ghosts_.fill(kFar);
    near_.clear();
    for (std::size_t i = 0; i < window_.leaves().size(); ++i) {
      const WindowLeaf& leaf = window_.leaves()[i];
      if (!is_in_table(leaf, 1)) continue;
      spread_ghosts(leaf, static_cast<std::uint16_t>(near_.size()));
      near_.push_back(static_cast<std::uint16_t>(i));
    }
  }
  void spread_ghosts(const WindowLeaf& leaf, std::uint16_t number) {
    const std::uint32_t beside = 7u << (leaf.x - 1 + kHalo);
    const Vec3f mean = leaf.mean();
    for (int row = 0; row < 9; ++row) {
      const int y = leaf.y + row % 3 - 1;
      const int z = leaf.z + row / 3 - 1;
      std::uint32_t unknown = unknown_[row_at(y, z)] & beside;
      if (unknown == 0) continue;
      const float dy = static_cast<float>(row % 3 - 1) - mean.y();
      const float dz = static_cast<float>(row / 3 - 1) - mean.z();
      const float across = dy * dy + dz * dz;
      for (; unknown != 0; unknown &= unknown - 1) {
        const int x = __builtin_ctz(unknown) - kHalo;
        const float dx = static_cast<float>(x - leaf.x) - mean.x();
        const float squared = dx * dx + across;
        const std::size_t i = at(x, y, z);
        if (squared >= ghosts_[i]) continue;
        ghosts_[i] = squared;
        ghost_leaves_[i] = number;
      }
    }
  }

  /// Gives unknown voxels the signed distance to the plane of their nearest leaf.
  void take_ghosts(DistanceBlock* out) const {
    for (int z = -1; z <= kBlockSide; ++z) {
      for (int y = -1; y <= kBlockSide; ++y) {
        for (std::uint32_t unknown = unknown_[row_at(y, z)]; unknown != 0; unknown &= unknown - 1) {
          const int x = __builtin_ctz(unknown) - kHalo;
          if (ghosts_[at(x, y, z)] != kFar) out->set(x, y, z, ghost_value(x, y, z));
        }
      }
    }
  }
  float ghost_value(int x, int y, int z) const {
    const std::size_t i = at(x, y, z);
    const WindowLeaf& leaf = window_.leaves()[near_[ghost_leaves_[i]]];
    const LeafNormal& normal = normals_[ghost_leaves_[i]];
    if (normal.quality >= kSolidQuality)
      return normal.normal.dot(Vec3f(x - leaf.x, y - leaf.y, z - leaf.z) - leaf.mean());
    // Behind what has no free side at all is more of it; around a thin thing is outside.
    const float distance = std::sqrt(ghosts_[i]);
    return normal.quality == 0.f ? -distance : distance;
  }

  float inside_value(const WindowLeaf& leaf, const LeafNormal& normal) const {
    constexpr float kDeepest = -0.1f;
    const float to_plane = -normal.normal.dot(leaf.mean());
    if (normal.quality >= kPlanarQuality) return to_plane;
    if (normal.quality >= kOneSidedQuality) return std::min(to_plane, kDeepest);
    int squared = squared_to_free(leaf, 1);
    // What lies in unknown space may be one voxel thick; only what is enclosed is known to be deep inside. Beyond the
    // band nothing would change.
    if (squared == 0)
      squared = is_enclosed(leaf) ? squared_to_free(leaf, static_cast<int>(std::ceil(band_ + 0.5f)) - 1) : 1;
    if (squared == 0) return -band_;
    return std::max(0.5f - std::sqrt(static_cast<float>(squared)), -band_);
  }

  /// Squared distance in voxels to the nearest free voxel at most `reach` away on each axis; 0 when there is none.
  int squared_to_free(const WindowLeaf& leaf, int reach) const {
    const int bit = leaf.x + kHalo;
    const std::uint32_t in_reach = (2u << (bit + reach)) - (1u << (bit - reach));
    int best = 0;
    for (int dz = -reach; dz <= reach; ++dz) {
      for (int dy = -reach; dy <= reach; ++dy) {
        const std::uint32_t free = window_.free(leaf.y + dy, leaf.z + dz) & in_reach;
        if (free == 0) continue;
        const std::uint32_t behind = free >> bit, before = free & ((2u << bit) - 1u);
        const int dx = std::min(behind != 0 ? __builtin_ctz(behind) : kFarAway,
                                before != 0 ? bit - (31 - __builtin_clz(before)) : kFarAway);
        const int squared = dx * dx + dy * dy + dz * dz;
        if (best == 0 || squared < best) best = squared;
      }
    }
    return best;
  }

  bool is_enclosed(const WindowLeaf& leaf) const {
    const auto is_occupied = [&](int dx, int dy, int dz) {
      return window_.state(leaf.x + dx, leaf.y + dy, leaf.z + dz) == State::kOccupied;
    };
    return is_occupied(1, 0, 0) && is_occupied(-1, 0, 0) && is_occupied(0, 1, 0) && is_occupied(0, -1, 0) &&
           is_occupied(0, 0, 1) && is_occupied(0, 0, -1);
  }

  float band_ = 0.f;
  FieldWindow window_;
  std::vector<std::uint16_t> near_;  ///< leaves by number
  std::vector<LeafNormal> normals_;
  TableFloats squared_;
  std::array<std::uint32_t, (kSide + 4) * (kSide + 4)> unknown_;
  TableFloats ghosts_;                                             ///< from unknown voxels to their nearest leaf
  std::array<std::uint16_t, kSide * kSide * kSide> ghost_leaves_;  ///< nearest one, by its number among near_
};

std::shared_ptr<const DistanceBlock> copy_values(const CompressedField& field, const Index3& block) {
  auto out = std::make_shared<DistanceBlock>(field.band());
  const Index3 first = geometry::voxel_at(block, 0);
  for (int z = -1; z <= kBlockSide; ++z) {
    for (int y = -1; y <= kBlockSide; ++y) {
      for (int x = -1; x <= kBlockSide; ++x) {
        const auto value = field.value(first + Index3{x, y, z});
        if (value) out->set(x, y, z, *value);
      }
    }
  }
  return out->is_empty() ? nullptr : out;
}

}  // namespace

bool DistanceBlock::corners(int x, int y, int z, std::array<float, 8>* values) const {
  const std::int16_t* low = &codes_[at(x, y, z)];
  for (std::size_t i = 0; i < 8; ++i) {
    const std::int16_t code = low[(i & 1) + kSide * ((i >> 1) & 1) + kSide * kSide * (i >> 2)];
    if (code == kNone) return false;
    (*values)[i] = static_cast<float>(code) * scale_;
  }
  return true;
}

void DistanceBlock::set(int x, int y, int z, float distance) {
  const float code = std::min(32767.f, std::max(-32767.f, distance / scale_));
  codes_[at(x, y, z)] = static_cast<std::int16_t>(code + (code < 0.f ? -0.5f : 0.5f));
}

bool DistanceBlock::is_empty() const {
  return std::all_of(codes_.begin(), codes_.end(), [](std::int16_t code) { return code == kNone; });
}

std::shared_ptr<const DistanceBlock> derive_distances(const CompressedField& field, const Index3& block) {
  if (field.has_values()) return copy_values(field, block);
  static thread_local std::unique_ptr<Deriver> deriver;
  if (!deriver) deriver = std::make_unique<Deriver>();
  return deriver->derive(field, block);
}

}  // namespace voxnav::submap
