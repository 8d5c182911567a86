// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/distance_block.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "voxnav/submap/field_window.hpp"

namespace voxnav::submap {
namespace {

using containers::State;
using geometry::Index3;
using geometry::kBlockSide;
using geometry::Vec3f;

constexpr float kFar = std::numeric_limits<float>::infinity();
constexpr int kRow = FieldWindow::kSide;  // squared distances are kept in rows as wide as the window
constexpr int kSide = DistanceBlock::kSide;

bool is_in_table(int c) { return c >= -1 && c <= kBlockSide; }

/// Derives one block; keeps its memory for the next one.
class Deriver {
 public:
  std::shared_ptr<const DistanceBlock> derive(const CompressedField& field, const Index3& block) {
    band_ = static_cast<float>(field.band());
    window_.load(field, block, static_cast<int>(std::ceil(field.band() + 0.5)) + 1);
    if (window_.leaves().empty()) return nullptr;
    auto out = std::make_shared<DistanceBlock>(field.band());
    splat();
    take_free(out.get());
    ghosts_.fill(kFar);
    for (const WindowLeaf& leaf : window_.leaves()) {
      const bool is_near =
          std::min({leaf.x, leaf.y, leaf.z}) >= -2 && std::max({leaf.x, leaf.y, leaf.z}) <= kBlockSide + 1;
      if (!is_near) continue;
      const LeafNormal normal = estimate_normal(window_, leaf);
      spread_ghosts(leaf, normal, out.get());
      if (is_in_table(leaf.x) && is_in_table(leaf.y) && is_in_table(leaf.z))
        out->set(leaf.x, leaf.y, leaf.z, inside_value(leaf, normal));
    }
    return out;
  }

 private:
  static std::size_t row_at(int y, int z) { return static_cast<std::size_t>(kRow * ((y + 1) + kSide * (z + 1))); }

  /// Squared distance of every voxel centre to the nearest surface point within the band.
  void splat() {
    std::fill(squared_.begin(), squared_.end(), kFar);
    const int reach = static_cast<int>(std::ceil(band_ + 0.5f)) + 1;
    for (const WindowLeaf& leaf : window_.leaves()) {
      if (std::min({leaf.x, leaf.y, leaf.z}) < -reach) continue;
      if (std::max({leaf.x, leaf.y, leaf.z}) >= kBlockSide + reach) continue;
      if (band_ <= 3.5f) {
        splat_one<8>(leaf);
      } else {
        splat_one<16>(leaf);
      }
    }
  }

  /// Rows of a fixed length are vectorised, which costs less than finding where the ball ends.
  template <int kLength>
  void splat_one(const WindowLeaf& leaf) {
    const Vec3f p = Vec3f(leaf.x, leaf.y, leaf.z) + leaf.mean;
    const float band2 = band_ * band_ * 1.0001f;
    const int first = std::max(0, std::min(kRow - kLength, static_cast<int>(std::ceil(p.x() - band_)) + kHalo));
    float along_x[kLength];
    for (int i = 0; i < kLength; ++i) {
      const float dx = static_cast<float>(first + i - kHalo) - p.x();
      along_x[i] = dx * dx;
    }
    const auto low = [&](float c) { return std::max(-1, static_cast<int>(std::ceil(c - band_))); };
    const auto high = [&](float c) { return std::min(kBlockSide, static_cast<int>(std::floor(c + band_))); };
    const int y1 = high(p.y());
    const int z1 = high(p.z());
    for (int z = low(p.z()); z <= z1; ++z) {
      for (int y = low(p.y()); y <= y1; ++y) {
        const float dy = static_cast<float>(y) - p.y();
        const float dz = static_cast<float>(z) - p.z();
        const float base = dy * dy + dz * dz;
        if (base > band2) continue;
        float* row = &squared_[row_at(y, z) + static_cast<std::size_t>(first)];
        for (int i = 0; i < kLength; ++i) row[i] = std::min(row[i], base + along_x[i]);
      }
    }
  }

  void take_free(DistanceBlock* out) const {
    constexpr std::uint32_t kTable = ((1u << kSide) - 1) << (kHalo - 1);
    for (int y = -1; y <= kBlockSide; ++y) {
      for (int x = -1; x <= kBlockSide; ++x) {
        for (std::uint32_t bits = window_.free(x, y) & kTable; bits != 0; bits &= bits - 1) {
          const int z = __builtin_ctz(bits) - kHalo;
          const float squared = squared_[row_at(y, z) + static_cast<std::size_t>(x + kHalo)];
          if (squared <= band_ * band_) out->set(x, y, z, std::sqrt(squared));
        }
      }
    }
  }

  /// Gives the unknown voxels around a leaf the signed distance to its plane, where it is their nearest leaf.
  void spread_ghosts(const WindowLeaf& leaf, const LeafNormal& normal, DistanceBlock* out) {
    for (int column = 0; column < 9; ++column) {
      const int x = leaf.x + column % 3 - 1;
      const int y = leaf.y + column / 3 - 1;
      if (!is_in_table(x) || !is_in_table(y)) continue;
      const std::uint32_t known = window_.free(x, y) | window_.occupied(x, y);
      for (int z = std::max(leaf.z - 1, -1); z <= std::min(leaf.z + 1, kBlockSide); ++z) {
        if ((known >> (z + kHalo)) & 1) continue;
        const Vec3f from_surface = Vec3f(x - leaf.x, y - leaf.y, z - leaf.z) - leaf.mean;
        const float squared = from_surface.squaredNorm();
        float& nearest = ghosts_[static_cast<std::size_t>((x + 1) + kSide * ((y + 1) + kSide * (z + 1)))];
        if (squared >= nearest) continue;
        nearest = squared;
        // Behind what has no free side at all is more of it; around a thin thing is outside.
        const bool is_one_sided = normal.quality >= kSolidQuality;
        const bool is_deep = normal.quality == 0.f;
        const float distance = std::sqrt(squared);
        out->set(x, y, z, is_one_sided ? normal.normal.dot(from_surface) : is_deep ? -distance : distance);
      }
    }
  }

  float inside_value(const WindowLeaf& leaf, const LeafNormal& normal) const {
    constexpr float kDeepest = -0.1f;
    const float to_plane = -normal.normal.dot(leaf.mean);
    if (normal.quality >= kPlanarQuality) return to_plane;
    if (normal.quality >= kOneSidedQuality) return std::min(to_plane, kDeepest);
    int squared = squared_to_free(leaf, 1);
    // What lies in unknown space may be one voxel thick; only what is enclosed is known to be deep inside.
    if (squared == 0)
      squared = is_enclosed(leaf) ? squared_to_free(leaf, static_cast<int>(std::ceil(band_ + 0.5f))) : 1;
    if (squared == 0) return -band_;
    return std::max(0.5f - std::sqrt(static_cast<float>(squared)), -band_);
  }

  /// Squared distance in voxels to the nearest free voxel at most `reach` away on each axis; 0 when there is none.
  int squared_to_free(const WindowLeaf& leaf, int reach) const {
    int best = 0;
    for (int dy = -reach; dy <= reach; ++dy) {
      for (int dx = -reach; dx <= reach; ++dx) {
        const std::uint32_t free = window_.free(leaf.x + dx, leaf.y + dy);
        if (free == 0) continue;
        for (int dz = -reach; dz <= reach; ++dz) {
          const int squared = dx * dx + dy * dy + dz * dz;
          if (((free >> (leaf.z + dz + kHalo)) & 1) && (best == 0 || squared < best)) best = squared;
        }
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

  static constexpr int kHalo = FieldWindow::kHalo;
  float band_ = 0.f;
  FieldWindow window_;
  std::array<float, kRow * kSide * kSide> squared_;
  std::array<float, kSide * kSide * kSide> ghosts_;
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
