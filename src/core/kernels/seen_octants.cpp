// SPDX-License-Identifier: BSD-3-Clause
#include "kernels/seen_octants.hpp"

#include <algorithm>

#include "kernels/beam_places.hpp"
#include "kernels/bits.hpp"
#include "kernels/blend_moments.hpp"

namespace voxnav::kernels {
namespace {

using namespace lanes;  // NOLINT: the vector types of this file

/// Table that lists, for each set of lanes, their numbers in rising order.
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

/// For each voxel a list of numbers of beams of the scan.
struct Beams {
  static constexpr int kMost = 64;
  alignas(32) std::int32_t counts[kLanes] = {};
  std::int32_t numbers[kLanes][kMost + kLanes];

  Beams() {
    for (auto& list : numbers) list[0] = 0;
  }
  /// Adds the chosen pixels of a row without branches, which a processor could not predict.
  VOXNAV_INLINE void add(int lane, const BeamPixel* pixels, unsigned which) {
    const auto order = loaded<Ints>(kSetLanes.of[which]);
    store(shuffled(loaded<Ints>(pixels) & kBeamMask, order), numbers[lane] + counts[lane]);
    counts[lane] += static_cast<std::int32_t>(count_bits(which));
  }
  VOXNAV_INLINE bool is_full(int lane) const { return counts[lane] > kMost; }
};

struct Vec {
  Floats x, y, z;
};
VOXNAV_INLINE Floats dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
VOXNAV_INLINE Vec operator+(const Vec& a, const Vec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
/// Returns scale * a - b.
VOXNAV_INLINE Vec along(Floats scale, const Vec& a, const Vec& b) {
  return {scale * a.x - b.x, scale * a.y - b.y, scale * a.z - b.z};
}
VOXNAV_INLINE Vec rotated(const Eigen::Matrix3f& by, const Vec& v) {
  const auto row = [&](int k) { return by(k, 0) * v.x + by(k, 1) * v.y + by(k, 2) * v.z; };
  return {row(0), row(1), row(2)};
}
/// Returns square roots with a relative error of a thousandth, by two steps of Newton's method from a guess that halves
/// the exponent.
VOXNAV_INLINE Floats square_root(Floats x) {
  Ints bits;
  std::memcpy(&bits, &x, sizeof bits);
  bits = (bits >> 1) + 0x1FBD1DF5;
  Floats root;
  std::memcpy(&root, &bits, sizeof root);
  root = 0.5f * (root + x / root);
  return 0.5f * (root + x / root);
}

/// Covariances of hits in the form in which Mahalanobis distances are computed from them.
struct Spreads {
  Floats xx, xy, xz, yy, yz, zz;  ///< adjugate of the covariance: its inverse times the determinant
  Floats determinant;
  VOXNAV_INLINE Vec weighted(const Vec& v) const {
    return {xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z};
  }
};

/// Gathers number i of each voxel.
VOXNAV_INLINE Floats each_of(const std::int16_t* const* numbers, std::size_t i, float unit) {
  Ints out;
  for (int k = 0; k < kLanes; ++k) out[k] = numbers[k][i];
  return floats(out) * unit;
}

/// Prepares the covariances of the hits, with `least` added to their standard deviations.
VOXNAV_INLINE Spreads spreads_of(const AskedVoxels& asked, float least) {
  const auto entry = [&](std::size_t i) { return each_of(asked.covariances, i, 1.0f / kCovarianceUnits); };
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

VOXNAV_INLINE Vec means_of(const AskedVoxels& asked) {
  const auto axis = [&](std::size_t i) { return each_of(asked.means, i, 0.5f / kMeanUnits); };
  return {axis(0), axis(1), axis(2)};
}

VOXNAV_INLINE Vec centers_of(const AskedVoxels& asked, const geometry::Vec3f& first_center) {
  const auto offsets = loaded<Ints>(asked.offsets);
  return {floats(offsets & 15) + first_center.x(), floats((offsets >> 4) & 15) + first_center.y(),
          floats(offsets >> 8) + first_center.z()};
}

/// Tests the beams that were collected, with one lane for each voxel, and empties the lists.
VOXNAV_INLINE void ask(const BeamImages& images, const SightRules& rules, const AskedVoxels& asked, const Vec& center,
                       Beams* beams, Ints* octants) {
  const Vec mean = center + means_of(asked);
  const Spreads spread = spreads_of(asked, rules.spread);
  const float reach = rules.longest - rules.behind;
  const float most_sq = reach > 0.0f ? reach * reach : -1.0f;
  const float least_sq = rules.behind * rules.behind;
  const Floats limit = rules.sigmas * rules.sigmas * spread.determinant;
  const auto counts = loaded<Ints>(beams->counts);
  for (std::int32_t i = 0; i < highest(counts); ++i) {
    Floats x{}, y{}, z{};
    for (int k = 0; k < kLanes; ++k) {
      const std::int32_t* numbers = beams->numbers[k];
      const auto beam = static_cast<std::uint32_t>(numbers[i < beams->counts[k] ? i : 0]);
      const float* from = images.ends + beam * images.stride;
      x[k] = from[0];
      y[k] = from[1];
      z[k] = from[2];
    }
    const Vec end = rotated(rules.to_window, {x, y, z});
    const Floats end_sq = dot(end, end);
    const Floats inverse_sq = 1.0f / larger(end_sq, Floats{} + 1e-20f);
    // The point of the beam nearest to the voxel's centre, relative to that centre.
    const Vec at = along(dot(center, end) * inverse_sq, end, center);
    const Ints inside = (absolute(at.x) <= 0.5f) & (absolute(at.y) <= 0.5f) & (absolute(at.z) <= 0.5f);
    // The length of the beam behind the hits; beams are cut at their longest believed length.
    const Floats share = dot(mean, end) * inverse_sq;
    const Ints is_behind =
        (share < 1.0f) & ((1.0f - share) * (1.0f - share) * end_sq >= least_sq) & (share * share * end_sq <= most_sq);
    // Squared Mahalanobis distance of the line from the hits, times the determinant.
    const Vec across = along(share, end, mean), weighted_end = spread.weighted(end);
    const Floats cross = dot(across, weighted_end);
    const Floats off = dot(across, spread.weighted(across)) * dot(end, weighted_end) - cross * cross;
    const Ints meets = off <= limit * dot(end, weighted_end);
    // The octants before and behind that point count: with the point alone, beams along a diagonal would reach six
    // octants at most.
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

VOXNAV_INLINE void look(const BeamImages& images, const SightRules& rules, const geometry::Vec3f& first_center,
                        const AskedVoxels& asked, std::int32_t* octants) {
  const Vec center = centers_of(asked, first_center);
  const Vec center_L = rotated(rules.to_frame_L, center);
  const Floats shortest_m = (exact_root(dot(center, center)) + (rules.behind - kHalfDiagonal)) * rules.resolution_m;
  BeamPlaces places;
  find_places(images, center_L.x, center_L.y, center_L.z, kBallRadius * rules.resolution_m, shortest_m, &places);
  Beams beams;
  Ints seen{};
  for (int lane = 0; lane < asked.size; ++lane) {
    const BeamPixel* row = places.first[static_cast<std::size_t>(lane)];
    for (int v = 0; v < places.height[lane]; ++v, row += places.side[lane]) {
      for (int u = 0; u < places.width[lane]; u += kLanes) {
        const unsigned inside = (2u << std::min(places.width[lane] - u - 1, kLanes - 1)) - 1u;
        beams.add(lane, row + u, reaching(row + u, places.least[lane]) & inside);
        if (beams.is_full(lane)) ask(images, rules, asked, center, &beams, &seen);
      }
    }
  }
  ask(images, rules, asked, center, &beams, &seen);
  store(seen, octants);
}

void look_plain(const BeamImages& images, const SightRules& rules, const geometry::Vec3f& first_center,
                const AskedVoxels& asked, std::int32_t* octants) {
  look(images, rules, first_center, asked, octants);
}
VOXNAV_WIDE void look_wide(const BeamImages& images, const SightRules& rules, const geometry::Vec3f& first_center,
                           const AskedVoxels& asked, std::int32_t* octants) {
  look(images, rules, first_center, asked, octants);
}

}  // namespace

void seen_octants(const BeamImages& images, const SightRules& rules, const geometry::Vec3f& first_center,
                  const AskedVoxels& asked, std::int32_t* octants) {
  (is_wide() ? look_wide : look_plain)(images, rules, first_center, asked, octants);
}

}  // namespace voxnav::kernels
