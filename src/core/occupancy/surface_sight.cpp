// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/surface_sight.hpp"

#include "voxnav/base/lanes.hpp"
#include "voxnav/occupancy/byte_ops.hpp"

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

/// Some beams of the scan, by number.
struct SurfaceSight::Beams {
  static constexpr int kMost = 64;
  int count = 0;
  std::int32_t numbers[kMost + 2 * kLanes];

  /// Without branches, which nobody could predict.
  VOXNAV_INLINE void add(const BeamImage::Pixel* pixels, unsigned which) {
    static_assert(BeamImage::kTogether == kLanes, "a row fills the lanes");
    const auto order = loaded<Ints>(kSetLanes.of[which]);
    store(__builtin_shuffle(loaded<Ints>(pixels) & BeamImage::kBeamMask, order), numbers + count);
    count += static_cast<int>(count_bits(which));
  }
  /// The lanes behind the last beam repeat it, which changes nothing.
  VOXNAV_INLINE void fill_up() {
    for (int i = count; i % kLanes != 0; ++i) numbers[i] = numbers[count - 1];
  }
};

/// What beams are asked about, seen from the sensor along the window's axes, voxel edges.
struct SurfaceSight::Target {
  geometry::Vec3f center;  ///< of the voxel
  const SurfaceLeaf* leaf;
};

namespace {

struct Vec {
  Floats x, y, z;
};
VOXNAV_INLINE Floats dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
VOXNAV_INLINE Floats dot(const geometry::Vec3f& a, const Vec& b) { return a.x() * b.x + a.y() * b.y + a.z() * b.z; }
/// scale * a - b
VOXNAV_INLINE Vec along(Floats scale, const Vec& a, const geometry::Vec3f& b) {
  return {scale * a.x - b.x(), scale * a.y - b.y(), scale * a.z - b.z()};
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
VOXNAV_INLINE Vec weighted(const HitSpread& spread, const Vec& v) {
  const auto& m = spread.adjugate;
  return {m[0] * v.x + m[1] * v.y + m[2] * v.z, m[1] * v.x + m[3] * v.y + m[4] * v.z,
          m[2] * v.x + m[4] * v.y + m[5] * v.z};
}

}  // namespace

SurfaceSight::SurfaceSight(const BeamImage& beams, const ScanFrame& frame, float resolution_m, const MissGuard& guard)
    : beams_(beams),
      origin_(frame.origin),
      rotation_(frame.rotation),
      resolution_m_(resolution_m),
      longest_(beams.longest_m() / resolution_m),
      guard_(guard) {}

/// Octants of the voxel that beams went through behind nothing; all of them when one met where the hits were. Without
/// square roots: lengths are compared by their squares.
VOXNAV_INLINE std::uint8_t SurfaceSight::octants_seen(const Target& target, Beams* beams) const {
  beams->fill_up();
  const geometry::Vec3f center = target.center, mean = center + target.leaf->offset();
  const HitSpread spread = target.leaf->spread(guard_.spread_voxels);
  const float reach = longest_ - guard_.end_voxels;
  const float most_sq = reach > 0.0f ? reach * reach : -1.0f;
  const float least_sq = guard_.end_voxels * guard_.end_voxels;
  const float limit = guard_.sigmas * guard_.sigmas * spread.determinant;
  Ints all{};
  for (int i = 0; i < beams->count; i += kLanes) {
    Floats x, y, z;
    for (int k = 0; k < kLanes; ++k) {
      const float* end_L = beams_.end_of(static_cast<std::uint32_t>(beams->numbers[i + k]));
      x[k] = end_L[0];
      y[k] = end_L[1];
      z[k] = end_L[2];
    }
    const auto row = [&](int k) { return rotation_(k, 0) * x + rotation_(k, 1) * y + rotation_(k, 2) * z; };
    const Vec end{row(0), row(1), row(2)};
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
    const Vec across = along(share, end, mean), weighted_end = weighted(spread, end);
    const Floats cross = dot(across, weighted_end);
    const Floats off = dot(across, weighted(spread, across)) * dot(end, weighted_end) - cross * cross;
    const Ints meets = off <= limit * dot(end, weighted_end);
    // Octants before and after that point: those at it alone would be six at most for beams along a diagonal.
    const Floats quarter = 0.25f * square_root(inverse_sq);
    const auto octant_at = [&](Floats ahead) {
      const Floats px = at.x + ahead * end.x, py = at.y + ahead * end.y, pz = at.z + ahead * end.z;
      return (Ints{} + 1) << (((px > 0.0f) & 1) | ((py > 0.0f) & 2) | ((pz > 0.0f) & 4));
    };
    all |= (meets ? Ints{} + 0xFF : octant_at(-quarter) | octant_at(quarter)) & inside & is_behind & (end_sq > 0.0f);
  }
  std::int32_t out = 0;
  for (int i = 0; i < kLanes; ++i) out |= all[i];
  beams->count = 0;
  return static_cast<std::uint8_t>(out);
}

VOXNAV_INLINE bool SurfaceSight::judge(const geometry::Vec3f& center, SurfaceLeaf* leaf) const {
  constexpr float kHalfDiagonal = 0.8661f;
  const Target target{center - origin_, leaf};
  const geometry::Vec3f center_L = rotation_.transpose() * target.center * (resolution_m_ * resolution_m_);
  const float shortest = target.center.norm() + guard_.end_voxels - kHalfDiagonal;
  Beams beams;
  const auto collect = [&](const BeamImage::Pixel* pixels, unsigned which) VOXNAV_INLINE_LAMBDA {
    beams.add(pixels, which);
    if (beams.count <= Beams::kMost) return false;
    leaf->octants |= octants_seen(target, &beams);
    return leaf->octants == 0xFF;
  };
  beams_.for_beams_near(center_L, 0.6f * resolution_m_, shortest * resolution_m_, collect);
  if (beams.count > 0) leaf->octants |= octants_seen(target, &beams);
  if (static_cast<int>(count_bits(leaf->octants)) < guard_.octants) return false;
  leaf->octants = 0;
  return leaf->is_refuted_by_seeing_through(guard_.patience);
}

bool SurfaceSight::judge_plain(const geometry::Vec3f& center, SurfaceLeaf* leaf) const { return judge(center, leaf); }
VOXNAV_WIDE bool SurfaceSight::judge_wide(const geometry::Vec3f& center, SurfaceLeaf* leaf) const {
  return judge(center, leaf);
}

bool SurfaceSight::refutes(const geometry::Vec3f& center, SurfaceLeaf* leaf) const {
  return base::is_wide() ? judge_wide(center, leaf) : judge_plain(center, leaf);
}

}  // namespace voxnav::occupancy
