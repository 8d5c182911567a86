// SPDX-License-Identifier: BSD-3-Clause
#include "kernels/blend_moments.hpp"

#include <algorithm>
#include <cstddef>

#include "kernels/lanes.hpp"

namespace voxnav::kernels {
namespace {

using namespace lanes;  // NOLINT: the vector types of this file

using Shorts = std::int16_t __attribute__((vector_size(16)));

constexpr float kCovarianceUnit = 1.0f / kCovarianceUnits;  // divisions are slow
constexpr float kMostCovariance = 0.25f;

/// Rounds halves away from zero. std::lrint() would be a function call, as the build does not set -fno-math-errno.
VOXNAV_INLINE Ints rounded(Floats value) {
  return truncated(value + (value < 0.0f ? Floats{} - 0.5f : Floats{} + 0.5f));
}
VOXNAV_INLINE Floats clamped(Floats value, float limit) {
  return smaller(larger(value, Floats{} - limit), Floats{} + limit);
}
VOXNAV_INLINE Floats loaded_eight(const std::int16_t* from) {
  return floats(__builtin_convertvector(loaded<Shorts>(from), Ints));
}
VOXNAV_INLINE void store_six(Floats values, std::int16_t* to) {
  const Shorts out = __builtin_convertvector(rounded(values), Shorts);
  std::memcpy(to, &out, 6 * sizeof *to);
}

VOXNAV_INLINE void blend(const MomentUpdate& update, const StoredMoments& stored) {
  const float share = update.share, recent_share = update.recent_share;
  const float x = update.mean[0], y = update.mean[1], z = update.mean[2];
  const auto moved = [&](float to, int axis) {
    return to - static_cast<float>(stored.means[axis]) * (0.5f / kMeanUnits);
  };
  const float dx = moved(x, 0), dy = moved(y, 1), dz = moved(z, 2);
  const Floats means = loaded_eight(stored.means);
  const Floats shares{share, share, share, recent_share, recent_share, recent_share, 0.0f, 0.0f};
  store_six(means + shares * (Floats{x, y, z, x, y, z, 0.0f, 0.0f} * (2.0f * kMeanUnits) - means), stored.means);
  const auto& c = update.covariance;
  const Floats products{dx * dx, dx * dy, dx * dz, dy * dy, dy * dz, dz * dz, 0.0f, 0.0f};
  const Floats mixed = (1.0f - share) * (loaded_eight(stored.covariance) * kCovarianceUnit + share * products) +
                       share * Floats{c[0], c[1], c[2], c[3], c[4], c[5], 0.0f, 0.0f};
  store_six(clamped(mixed, kMostCovariance) * kCovarianceUnits, stored.covariance);
}
void blend_plain(const MomentUpdate& update, const StoredMoments& stored) { blend(update, stored); }
VOXNAV_WIDE void blend_wide(const MomentUpdate& update, const StoredMoments& stored) { blend(update, stored); }

std::int16_t rounded_scalar(float value) {
  return static_cast<std::int16_t>(static_cast<std::int32_t>(value + (value < 0.0f ? -0.5f : 0.5f)));
}

}  // namespace

void blend_moments(const MomentUpdate& update, const StoredMoments& stored) {
  (is_wide() ? blend_wide : blend_plain)(update, stored);
}

void reference::blend_moments(const MomentUpdate& update, const StoredMoments& stored) {
  std::array<float, 3> moved;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    moved[axis] = update.mean[axis] - static_cast<float>(stored.means[axis]) * (0.5f / kMeanUnits);
  }
  for (std::size_t i = 0; i < 6; ++i) {
    const float share = i < 3 ? update.share : update.recent_share;
    const auto mean = static_cast<float>(stored.means[i]);
    stored.means[i] = rounded_scalar(mean + share * (update.mean[i % 3] * (2.0f * kMeanUnits) - mean));
  }
  constexpr std::size_t kRow[6] = {0, 0, 0, 1, 1, 2}, kColumn[6] = {0, 1, 2, 1, 2, 2};
  for (std::size_t i = 0; i < 6; ++i) {
    const float before = static_cast<float>(stored.covariance[i]) * kCovarianceUnit;
    const float between = update.share * (moved[kRow[i]] * moved[kColumn[i]]);
    const float mixed = (1.0f - update.share) * (before + between) + update.share * update.covariance[i];
    stored.covariance[i] =
        rounded_scalar(std::min(std::max(mixed, -kMostCovariance), kMostCovariance) * kCovarianceUnits);
  }
}

}  // namespace voxnav::kernels
