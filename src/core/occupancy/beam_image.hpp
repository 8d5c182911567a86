// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/seen_octants.hpp"

namespace voxnav::occupancy {

/// The beams of one scan by direction, so that those through a given voxel are found without looking at all of them:
/// six square images around the sensor (a cube map), each pixel with one of the beams that fall into it, and the same
/// at a quarter of the resolution for what is near. Frame L.
class BeamImage {
 public:
  /// Takes beams with ranges between nearest_m and farthest_m; those that went farther count as farthest_m long, or
  /// are left out. The points must stay where they are as long as beams are looked up. Of several beams in a pixel
  /// the first or the last is kept, in turn from scan to scan. Of more than 2^20 points only every second, third, ...
  /// is taken.
  void build(const float* points, std::size_t n, std::size_t stride, float nearest_m, float farthest_m,
             bool use_farther);

  /// What kernels::seen_octants() looks beams up in; ends with the next build().
  kernels::BeamImages images() const { return {fine_.data(), coarse_.data(), points_, stride_, steps_per_m_}; }
  /// Beams are believed up to this length.
  float longest_m() const { return farthest_m_; }
  std::size_t memory_bytes() const { return (fine_.capacity() + coarse_.capacity()) * sizeof(kernels::BeamPixel); }

 private:
  void keep(kernels::BeamPixel beam, std::int32_t fine, std::int32_t coarse);

  const float* points_ = nullptr;
  std::size_t stride_ = 3;
  float farthest_m_ = 0.0f;
  float steps_per_m_ = 0.0f;  ///< of ranges in the images
  bool is_first_kept_ = false;
  std::vector<kernels::BeamPixel> fine_, coarse_;
};

}  // namespace voxnav::occupancy
