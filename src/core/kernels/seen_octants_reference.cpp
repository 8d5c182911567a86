// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstring>

#include "kernels/beam_places.hpp"
#include "kernels/blend_moments.hpp"
#include "kernels/seen_octants.hpp"

namespace voxnav::kernels::reference {
namespace {

struct Vec {
  float x, y, z;
};
float dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec along(float scale, const Vec& a, const Vec& b) { return {scale * a.x - b.x, scale * a.y - b.y, scale * a.z - b.z}; }
Vec rotated(const Eigen::Matrix3f& by, const Vec& v) {
  const auto row = [&](int k) { return by(k, 0) * v.x + by(k, 1) * v.y + by(k, 2) * v.z; };
  return {row(0), row(1), row(2)};
}
float square_root(float x) {
  std::int32_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  bits = (bits >> 1) + 0x1FBD1DF5;
  float root;
  std::memcpy(&root, &bits, sizeof root);
  root = 0.5f * (root + x / root);
  return 0.5f * (root + x / root);
}

/// A symmetric matrix.
struct Symmetric {
  float xx, xy, xz, yy, yz, zz;
  Vec times(const Vec& v) const {
    return {xx * v.x + xy * v.y + xz * v.z, xy * v.x + yy * v.y + yz * v.z, xz * v.x + yz * v.y + zz * v.z};
  }
};

/// One voxel, and the hits in it.
struct Voxel {
  Vec center, mean;
  Symmetric adjugate;  ///< of the covariance: its inverse times the determinant
  float determinant;
};

Voxel voxel_of(const AskedVoxels& asked, int lane, const SightRules& rules, const geometry::Vec3f& first_center) {
  Voxel out;
  const std::int32_t offset = asked.offsets[lane];
  out.center = {static_cast<float>(offset & 15) + first_center.x(),
                static_cast<float>((offset >> 4) & 15) + first_center.y(),
                static_cast<float>(offset >> 8) + first_center.z()};
  const auto mean = [&](int axis) { return static_cast<float>(asked.means[lane][axis]) * (0.5f / kMeanUnits); };
  out.mean = {out.center.x + mean(0), out.center.y + mean(1), out.center.z + mean(2)};
  const auto entry = [&](int i) { return static_cast<float>(asked.covariances[lane][i]) * (1.0f / kCovarianceUnits); };
  const float least = rules.spread * rules.spread;
  const float xx = entry(0) + least, xy = entry(1), xz = entry(2), yy = entry(3) + least, yz = entry(4);
  const float zz = entry(5) + least;
  out.adjugate = {yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy,
                  xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy};
  out.determinant = xx * out.adjugate.xx + xy * out.adjugate.xy + xz * out.adjugate.xz;
  return out;
}

/// Returns the octants that one beam saw through, for seen_octants().
std::int32_t octants_of_beam(const Voxel& voxel, const Vec& end, const SightRules& rules) {
  const float end_sq = dot(end, end);
  if (!(end_sq > 0.0f)) return 0;
  const float inverse_sq = 1.0f / std::max(end_sq, 1e-20f);
  const Vec at = along(dot(voxel.center, end) * inverse_sq, end, voxel.center);
  if (!(std::abs(at.x) <= 0.5f && std::abs(at.y) <= 0.5f && std::abs(at.z) <= 0.5f)) return 0;
  const float share = dot(voxel.mean, end) * inverse_sq;
  const float reach = rules.longest - rules.behind;
  const bool is_behind = share < 1.0f && (1.0f - share) * (1.0f - share) * end_sq >= rules.behind * rules.behind;
  if (!is_behind || !(share * share * end_sq <= (reach > 0.0f ? reach * reach : -1.0f))) return 0;
  const Vec across = along(share, end, voxel.mean), weighted_end = voxel.adjugate.times(end);
  const float cross = dot(across, weighted_end), length = dot(end, weighted_end);
  const float off = dot(across, voxel.adjugate.times(across)) * length - cross * cross;
  if (off <= rules.sigmas * rules.sigmas * voxel.determinant * length) return 0xFF;
  const float quarter = 0.25f * square_root(inverse_sq);
  const auto octant_at = [&](float ahead) {
    const int x = at.x + ahead * end.x > 0.0f ? 1 : 0, y = at.y + ahead * end.y > 0.0f ? 2 : 0;
    return 1 << (x | y | (at.z + ahead * end.z > 0.0f ? 4 : 0));
  };
  return octant_at(-quarter) | octant_at(quarter);
}

/// The pixels of one image that a ball around a voxel touches, and the least one that counts.
struct Pixels {
  const BeamPixel* image;
  int face, side, first_u, last_u, first_v, last_v;
  BeamPixel least;
};

Pixels pixels_of(const BeamImages& images, const SightRules& rules, const Vec& center) {
  const Vec center_L = rotated(rules.to_frame_L, center);
  const auto at = cube_map::reference::project(center_L.x, center_L.y, center_L.z, 0.5f * kFineSide);
  const float reach = kBallRadius * rules.resolution_m * at.scale;
  const bool is_fine = reach <= 0.5f * kMostFinePixels;
  const auto pixel = [&](float coordinate) {
    return cube_map::reference::pixel(coordinate, kFineSide) / (is_fine ? 1 : kFineToCoarse);
  };
  const float shortest_m = (std::sqrt(dot(center, center)) + (rules.behind - kHalfDiagonal)) * rules.resolution_m;
  const float steps = std::min(std::max(shortest_m, 0.0f) * images.steps_per_m, static_cast<float>(kMaxBeamRange - 1));
  Pixels out{is_fine ? images.fine : images.coarse,
             at.face,
             is_fine ? kFineSide : kCoarseSide,
             pixel(at.u - reach),
             pixel(at.u + reach),
             pixel(at.v - reach),
             pixel(at.v + reach),
             (static_cast<BeamPixel>(steps) + 1) << kBeamBits};
  const bool is_outside = reach < 0.5f * kFineSide / 1.5f;  // the sensor is not in the ball, nor beside it
  if (!is_outside) out.last_v = out.first_v - 1;
  return out;
}

}  // namespace

void seen_octants(const BeamImages& images, const SightRules& rules, const geometry::Vec3f& first_center,
                  const AskedVoxels& asked, std::int32_t* octants) {
  for (int lane = 0; lane < asked.size; ++lane) {
    const Voxel voxel = voxel_of(asked, lane, rules, first_center);
    const Pixels pixels = pixels_of(images, rules, voxel.center);
    octants[lane] = 0;
    for (int v = pixels.first_v; v <= pixels.last_v; ++v) {
      for (int u = pixels.first_u; u <= pixels.last_u; ++u) {
        const BeamPixel pixel = pixels.image[(pixels.face * pixels.side + v) * pixels.side + u];
        if (pixel < pixels.least) continue;
        const float* end_L = images.ends + static_cast<std::size_t>(pixel & kBeamMask) * images.stride;
        octants[lane] |= octants_of_beam(voxel, rotated(rules.to_window, {end_L[0], end_L[1], end_L[2]}), rules);
      }
    }
  }
}

}  // namespace voxnav::kernels::reference
