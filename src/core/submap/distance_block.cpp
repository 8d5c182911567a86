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

using namespace base::lanes;  // NOLINT: the vector types of this file

constexpr float kFar = std::numeric_limits<float>::infinity();
constexpr int kHalo = FieldWindow::kHalo;
constexpr int kSide = DistanceBlock::kSide;
constexpr std::uint32_t kTable = ((1u << kSide) - 1) << (kHalo - 1);  // of a row of the window: what the block keeps

bool is_in_table(int c) { return c >= -1 && c <= kBlockSide; }
std::size_t at(int x, int y, int z) { return static_cast<std::size_t>((x + 1) + kSide * ((y + 1) + kSide * (z + 1))); }

/// Squared distance of every voxel centre of the table to the nearest surface point; right within the band.
using SquaredDistances = std::array<float, kSide * kSide * kSide>;

/// First and last of the voxel centres within `reach` of c.
struct Range {
  int first, last;
};
VOXNAV_INLINE Range around(float c, float reach) {
  const int low = static_cast<int>(c - reach + 16.0f) - 15;  // rounded up, without a call
  const int high = static_cast<int>(c + reach + 16.0f) - 16;
  return {low < -1 ? -1 : low, high > kBlockSide ? kBlockSide : high};
}

/// Rows of a fixed length are a few vectors, which costs less than finding where the ball ends; where nothing is free,
/// nobody asks.
template <int kVectors>
VOXNAV_INLINE void splat(const FieldWindow& window, const FieldWindow::Point& point, float band,
                         SquaredDistances* squared) {
  constexpr int kLength = kVectors * kLanes;
  constexpr std::uint32_t kRow = (1u << kLength) - 1;
  const float band2 = band * band * 1.0001f;
  int first = around(point[0], band).first;
  if (first > kBlockSide + 1 - kLength) first = kBlockSide + 1 - kLength;
  Floats along_x[kVectors];
  for (int i = 0; i < kVectors; ++i) {
    const Floats dx = static_cast<float>(first + i * kLanes) + Floats{0, 1, 2, 3, 4, 5, 6, 7} - point[0];
    along_x[i] = dx * dx;
  }
  const Range ys = around(point[1], band), zs = around(point[2], band);
  for (int z = zs.first; z <= zs.last; ++z) {
    const float dz = static_cast<float>(z) - point[2];
    for (int y = ys.first; y <= ys.last; ++y) {
      const float dy = static_cast<float>(y) - point[1];
      const float base = dy * dy + dz * dz;
      if (base > band2 || ((window.free(y, z) >> (first + kHalo)) & kRow) == 0) continue;
      float* row = &(*squared)[at(first, y, z)];
      for (int i = 0; i < kVectors; ++i) {
        store(smaller(base + along_x[i], loaded<Floats>(row + i * kLanes)), row + i * kLanes);
      }
    }
  }
}

VOXNAV_INLINE void splat_all(const FieldWindow& window, float band, SquaredDistances* squared) {
  // A leaf's point may lie half an edge nearer than its centre.
  const int reach = static_cast<int>(band + 1.5f);
  for (std::size_t i = 0; i < window.leaves().size(); ++i) {
    const WindowLeaf& leaf = window.leaves()[i];
    if (std::min({leaf.x, leaf.y, leaf.z}) < -reach) continue;
    if (std::max({leaf.x, leaf.y, leaf.z}) >= kBlockSide + reach) continue;
    if (band <= 3.5f) {
      splat<1>(window, window.points()[i], band, squared);
    } else {
      splat<2>(window, window.points()[i], band, squared);
    }
  }
}

/// Codes of the free voxels within the band.
VOXNAV_INLINE void take_free(const FieldWindow& window, float band, const SquaredDistances& squared,
                             DistanceBlock* out) {
  for (int z = -1; z <= kBlockSide; ++z) {
    for (int y = -1; y <= kBlockSide; ++y) {
      const std::uint32_t free = window.free(y, z);
      if ((free & kTable) == 0) continue;
      for (const int x : {-1, kLanes - 1, kBlockSide + 1 - kLanes}) {  // the last two overlap
        const Words bits = Words{} + (free >> (x + kHalo));
        const Floats distance_sq = loaded<Floats>(&squared[at(x, y, z)]);
        const Ints is_near = ((bits & Words{1, 2, 4, 8, 16, 32, 64, 128}) != 0) & (distance_sq <= band * band);
        out->set_eight(x, y, z, exact_root(distance_sq), is_near);
      }
    }
  }
}

VOXNAV_INLINE void measure_free(const FieldWindow& window, float band, SquaredDistances* squared, DistanceBlock* out) {
  splat_all(window, band, squared);
  take_free(window, band, *squared, out);
}
void measure_free_plain(const FieldWindow& window, float band, SquaredDistances* squared, DistanceBlock* out) {
  measure_free(window, band, squared, out);
}
VOXNAV_WIDE void measure_free_wide(const FieldWindow& window, float band, SquaredDistances* squared,
                                   DistanceBlock* out) {
  measure_free(window, band, squared, out);
}

/// Derives one block; keeps its memory for the next one.
class Deriver {
 public:
  std::shared_ptr<const DistanceBlock> derive(const CompressedField& field, const Index3& block) {
    band_ = static_cast<float>(field.band());
    window_.load(field, block, static_cast<int>(band_ + 1.5f));
    if (window_.leaves().empty()) return nullptr;
    auto out = std::make_shared<DistanceBlock>(field.band());
    squared_.fill(kFar);
    (base::is_wide() ? measure_free_wide : measure_free_plain)(window_, band_, &squared_, out.get());
    find_near();
    estimate_normals(window_, near_, &normals_);
    ghosts_.fill(kFar);
    for (std::size_t i = 0; i < near_.size(); ++i) {
      const WindowLeaf& leaf = window_.leaves()[near_[i]];
      spread_ghosts(leaf, normals_[i], out.get());
      if (is_in_table(leaf.x) && is_in_table(leaf.y) && is_in_table(leaf.z))
        out->set(leaf.x, leaf.y, leaf.z, inside_value(leaf, normals_[i]));
    }
    return out;
  }

 private:
  /// The leaves whose planes reach into the table.
  void find_near() {
    near_.clear();
    for (std::size_t i = 0; i < window_.leaves().size(); ++i) {
      const WindowLeaf& leaf = window_.leaves()[i];
      if (std::min({leaf.x, leaf.y, leaf.z}) < -2 || std::max({leaf.x, leaf.y, leaf.z}) > kBlockSide + 1) continue;
      near_.push_back(static_cast<std::uint16_t>(i));
    }
  }

  /// Gives the unknown voxels around a leaf the signed distance to its plane, where it is their nearest leaf.
  void spread_ghosts(const WindowLeaf& leaf, const LeafNormal& normal, DistanceBlock* out) {
    const std::uint32_t beside = (7u << (leaf.x - 1 + kHalo)) & kTable;
    for (int row = 0; row < 9; ++row) {
      const int y = leaf.y + row % 3 - 1;
      const int z = leaf.z + row / 3 - 1;
      if (!is_in_table(y) || !is_in_table(z)) continue;
      std::uint32_t unknown = beside & ~(window_.free(y, z) | window_.occupied(y, z));
      for (; unknown != 0; unknown &= unknown - 1) {
        const int x = __builtin_ctz(unknown) - kHalo;
        const Vec3f from_surface = Vec3f(x - leaf.x, y - leaf.y, z - leaf.z) - leaf.mean;
        const float squared = from_surface.squaredNorm();
        float& nearest = ghosts_[at(x, y, z)];
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
    // What lies in unknown space may be one voxel thick; only what is enclosed is known to be deep inside. Beyond the
    // band nothing would change.
    if (squared == 0)
      squared = is_enclosed(leaf) ? squared_to_free(leaf, static_cast<int>(std::ceil(band_ + 0.5f)) - 1) : 1;
    if (squared == 0) return -band_;
    return std::max(0.5f - std::sqrt(static_cast<float>(squared)), -band_);
  }

  /// Squared distance in voxels to the nearest free voxel at most `reach` away on each axis; 0 when there is none.
  int squared_to_free(const WindowLeaf& leaf, int reach) const {
    int best = 0;
    for (int dz = -reach; dz <= reach; ++dz) {
      for (int dy = -reach; dy <= reach; ++dy) {
        const std::uint32_t free = window_.free(leaf.y + dy, leaf.z + dz);
        if (free == 0) continue;
        for (int dx = -reach; dx <= reach; ++dx) {
          const int squared = dx * dx + dy * dy + dz * dz;
          if (((free >> (leaf.x + dx + kHalo)) & 1) && (best == 0 || squared < best)) best = squared;
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

  float band_ = 0.f;
  FieldWindow window_;
  std::vector<std::uint16_t> near_;
  std::vector<LeafNormal> normals_;
  SquaredDistances squared_;
  SquaredDistances ghosts_;
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
