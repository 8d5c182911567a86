// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/surface_sight.hpp"

#include <cstring>

#include "occupancy/byte_ops.hpp"

namespace voxnav::occupancy {

using namespace base::lanes;  // NOLINT: the vector types of this file

namespace {

/// For each set of lanes their numbers, lowest first.
struct SetLanes {
  std::int32_t of[256][kLanes];
  constexpr SetLanes() : of() {
    for (unsigned set = 0; set < 256; ++set) {
      int count = 0;
      for (unsigned lane = 0; lane < kLanes; ++lane) {
        if ((set >> lane & 1u) != 0) of[set][count++] = static_cast<std::int32_t>(lane);
      }
    }
  }
};
constexpr SetLanes kSetLanes;

}  // namespace

/// Up to eight voxels of a block that are asked together.
struct SurfaceSight::Group {
  int size = 0;
  alignas(32) std::int32_t offsets[kLanes] = {};
  SurfaceLeaf* leaves[kLanes];
  alignas(32) std::int32_t octants[kLanes];  ///< that beams of this scan went through

  void add(int offset, SurfaceLeaf* leaf) {
    offsets[size] = offset;
    leaves[size++] = leaf;
  }
  /// Lanes that would be empty repeat the first voxel.
  void fill_up() {
    for (int i = size; i < kLanes; ++i) {
      offsets[i] = offsets[0];
      leaves[i] = leaves[0];
    }
  }
};

/// For each voxel of a group some beams of the scan, by number.
struct SurfaceSight::Beams {
  static constexpr int kMost = 64;
  alignas(32) std::int32_t counts[kLanes] = {};
  std::int32_t numbers[kLanes][kMost + kLanes];

  Beams() {
    for (auto& list : numbers) list[0] = 0;
  }
  /// Without branches, which nobody could predict.
  VOXNAV_INLINE void add(int lane, const BeamImage::Pixel* pixels, unsigned which) {
    static_assert(BeamImage::kTogether == kLanes, "a row fills the lanes");
    const auto order = loaded<Ints>(kSetLanes.of[which]);
    store(__builtin_shuffle(loaded<Ints>(pixels) & BeamImage::kBeamMask, order), numbers[lane] + counts[lane]);
    counts[lane] += static_cast<std::int32_t>(count_bits(which));
  }
  VOXNAV_INLINE bool is_full(int lane) const { return counts[lane] > kMost; }
};

namespace {

struct Vec {
  Floats x, y, z;
};
VOXNAV_INLINE Floats dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
VOXNAV_INLINE Vec operator+(const Vec& a, const Vec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
/// scale * a - b
VOXNAV_INLINE Vec along(Floats scale, const Vec& a, const Vec& b) {
  return {scale * a.x - b.x, scale * a.y - b.y, scale * a.z - b.z};
}
VOXNAV_INLINE Vec rotated(const Eigen::Matrix3f& by, const Vec& v) {
  const auto row = [&](int k) { return by(k, 0) * v.x + by(k, 1) * v.y + by(k, 2) * v.z; };
  return {row(0), row(1), row(2)};
}
/// Square roots, to a thousandth: by two steps of Newton's method from a guess that halves the exponent.
VOXNAV_INLINE Floats square_root(Floats x) {
  Ints bits;
  std::memcpy(&bits, &x, sizeof bits);
  bits = (bits >> 1) + 0x1FBD1DF5;
  Floats root;
  std::memcpy(&root, &bits, sizeof root);
  root = 0.5f * (root + x / root);
  return 0.5f * (root + x / root);
}

/// Spreads of hits, ready to tell how many deviations away something is.
struct Spreads {
  Floats xx, xy, xz, yy, yz, zz;  ///< adjugate of the covariance: its inverse times the determinant
  Floats determinant;
  VOXNAV_INLINE Vec weighted(const Vec& v) const {
    return {xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z};
  }
};

/// One number of each leaf.
template <class Get>
VOXNAV_INLINE Floats each_of(SurfaceLeaf* const* leaves, float unit, Get get) {
  Ints out;
  for (int i = 0; i < kLanes; ++i) out[i] = get(*leaves[i]);
  return floats(out) * unit;
}

/// `least` (voxel edges) is added to the deviations of the hits.
VOXNAV_INLINE Spreads spreads_of(SurfaceLeaf* const* leaves, float least) {
  const auto entry = [&](std::size_t i) {
    return each_of(leaves, 1.0f / SurfaceLeaf::kCovarianceUnits,
                   [i](const SurfaceLeaf& leaf) { return leaf.covariance[i]; });
  };
  const Floats xx = entry(0) + least * least, xy = entry(1), xz = entry(2);
  const Floats yy = entry(3) + least * least, yz = entry(4), zz = entry(5) + least * least;
  Spreads out{yy * zz - yz * yz,
              xz * yz - xy * zz,
              xy * yz - xz * yy,
              xx * zz - xz * xz,
              xy * xz - xx * yz,
              xx * yy - xy * xy,
              {}};
  out.determinant = xx * out.xx + xy * out.xy + xz * out.xz;
  return out;
}

VOXNAV_INLINE Vec offsets_of(SurfaceLeaf* const* leaves) {
  const auto along_axis = [&](std::size_t axis) {
    return each_of(leaves, 0.5f / SurfaceLeaf::kMeanUnits, [axis](const SurfaceLeaf& leaf) { return leaf.mean[axis]; });
  };
  return {along_axis(0), along_axis(1), along_axis(2)};
}

/// Of the voxels at these places in a block.
VOXNAV_INLINE Vec centers_of(Ints offsets, const geometry::Vec3f& first_center) {
  static_assert(geometry::kBlockSide == 16, "four bits a coordinate");
  return {floats(offsets & 15) + first_center.x(), floats((offsets >> 4) & 15) + first_center.y(),
          floats(offsets >> 8) + first_center.z()};
}

}  // namespace

SurfaceSight::SurfaceSight(const BeamImage& beams, const ScanFrame& frame, float resolution_m, const MissGuard& guard)
    : beams_(beams),
      origin_(frame.origin),
      rotation_(frame.rotation),
      resolution_m_(resolution_m),
      longest_(beams.longest_m() / resolution_m),
      guard_(guard) {}

/// Octants of voxels that beams went through behind nothing; all of them when one met where the hits were. Without
/// square roots: lengths are compared by their squares. A lane for each voxel.
VOXNAV_INLINE void SurfaceSight::ask(const Group& group, const geometry::Vec3f& first_center, Beams* beams,
                                     Ints* octants) const {
  const Vec center = centers_of(loaded<Ints>(group.offsets), first_center);
  const Vec mean = center + offsets_of(group.leaves);
  const Spreads spread = spreads_of(group.leaves, guard_.spread_voxels);
  const float reach = longest_ - guard_.end_voxels;
  const float most_sq = reach > 0.0f ? reach * reach : -1.0f;
  const float least_sq = guard_.end_voxels * guard_.end_voxels;
  const Floats limit = guard_.sigmas * guard_.sigmas * spread.determinant;
  const auto counts = loaded<Ints>(beams->counts);
  for (std::int32_t i = 0; i < highest(counts); ++i) {
    Floats x{}, y{}, z{};
    for (int k = 0; k < kLanes; ++k) {
      const std::int32_t* numbers = beams->numbers[k];
      const float* from = beams_.end_of(static_cast<std::uint32_t>(numbers[i < beams->counts[k] ? i : 0]));
      x[k] = from[0];
      y[k] = from[1];
      z[k] = from[2];
    }
    const Vec end = rotated(rotation_, {x, y, z});
    const Floats end_sq = dot(end, end);
    const Floats inverse_sq = 1.0f / larger(end_sq, Floats{} + 1e-20f);
    // The nearest point of the beam to the voxel's centre, from there.
    const Vec at = along(dot(center, end) * inverse_sq, end, center);
    const Ints inside = (absolute(at.x) <= 0.5f) & (absolute(at.y) <= 0.5f) & (absolute(at.z) <= 0.5f);
    // How far it went on behind the hits; no farther than beams are believed.
    const Floats share = dot(mean, end) * inverse_sq;
    const Ints is_behind =
        (share < 1.0f) & ((1.0f - share) * (1.0f - share) * end_sq >= least_sq) & (share * share * end_sq <= most_sq);
    // Squared Mahalanobis distance of the line from the hits, times the determinant.
    const Vec across = along(share, end, mean), weighted_end = spread.weighted(end);
    const Floats cross = dot(across, weighted_end);
    const Floats off = dot(across, spread.weighted(across)) * dot(end, weighted_end) - cross * cross;
    const Ints meets = off <= limit * dot(end, weighted_end);
    // Octants before and after that point: those at it alone would be six at most for beams along a diagonal.
    const Floats quarter = 0.25f * square_root(inverse_sq);
    const auto octant_at = [&](Floats ahead) {
      const Floats px = at.x + ahead * end.x, py = at.y + ahead * end.y, pz = at.z + ahead * end.z;
      return (Ints{} + 1) << (((px > 0.0f) & 1) | ((py > 0.0f) & 2) | ((pz > 0.0f) & 4));
    };
    const Ints seen = meets ? Ints{} + 0xFF : octant_at(-quarter) | octant_at(quarter);
    *octants |= seen & inside & is_behind & (end_sq > 0.0f) & (counts > i);
  }
  store(Ints{}, beams->counts);
}

VOXNAV_INLINE void SurfaceSight::look(const geometry::Vec3f& first_center, Group* group) const {
  constexpr float kHalfDiagonal = 0.8661f;
  const Vec center = centers_of(loaded<Ints>(group->offsets), first_center);
  const Vec center_L = rotated(rotation_.transpose() * (resolution_m_ * resolution_m_), center);
  const Floats shortest = (exact_root(dot(center, center)) + (guard_.end_voxels - kHalfDiagonal)) * resolution_m_;
  BeamImage::Places places;
  beams_.find(center_L.x, center_L.y, center_L.z, 0.6f * resolution_m_, shortest, &places);
  Beams beams;
  Ints octants{};
  for (int lane = 0; lane < group->size; ++lane) {
    const BeamImage::Pixel* row = places.first[static_cast<std::size_t>(lane)];
    for (int v = 0; v < places.height[lane]; ++v, row += places.side[lane]) {
      for (int u = 0; u < places.width[lane]; u += kLanes) {
        const unsigned inside = (2u << std::min(places.width[lane] - u - 1, kLanes - 1)) - 1u;
        beams.add(lane, row + u, BeamImage::reaching(row + u, places.least[lane]) & inside);
        if (beams.is_full(lane)) ask(*group, first_center, &beams, &octants);
      }
    }
  }
  ask(*group, first_center, &beams, &octants);
  store(octants, group->octants);
}

void SurfaceSight::look_plain(const geometry::Vec3f& first_center, Group* group) const { look(first_center, group); }
VOXNAV_WIDE void SurfaceSight::look_wide(const geometry::Vec3f& first_center, Group* group) const {
  look(first_center, group);
}

void SurfaceSight::judge(const geometry::Vec3f& first_center, Group* group, VoxelBits* out) const {
  if (group->size == 0) return;
  group->fill_up();
  base::is_wide() ? look_wide(first_center, group) : look_plain(first_center, group);
  for (int i = 0; i < group->size; ++i) {
    SurfaceLeaf* leaf = group->leaves[i];
    leaf->octants = static_cast<std::uint8_t>(leaf->octants | group->octants[i]);
    if (static_cast<int>(count_bits(leaf->octants)) < guard_.octants) continue;
    leaf->octants = 0;
    if (!leaf->is_refuted_by_seeing_through(guard_.patience)) continue;
    (*out)[static_cast<std::size_t>(group->offsets[i] >> 6)] |= std::uint64_t{1} << (group->offsets[i] & 63);
  }
  group->size = 0;
}

VoxelBits SurfaceSight::refuted(const geometry::Index3& first_voxel, const VoxelBits& asked,
                                SurfaceLeaves* leaves) const {
  const geometry::Vec3f first_center =
      geometry::Vec3f(static_cast<float>(first_voxel.x), static_cast<float>(first_voxel.y),
                      static_cast<float>(first_voxel.z)) +
      geometry::Vec3f::Constant(0.5f) - origin_;
  VoxelBits out{};
  Group group;
  for (std::size_t word = 0; word < asked.size(); ++word) {
    for_each_bit(asked[word], [&](int bit) {
      const int offset = static_cast<int>(64 * word) + bit;
      group.add(offset, leaves->find(offset));
      if (group.size == kLanes) judge(first_center, &group, &out);
    });
  }
  judge(first_center, &group, &out);
  return out;
}

}  // namespace voxnav::occupancy
