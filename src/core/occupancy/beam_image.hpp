// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/seen_octants.hpp"

namespace voxnav::occupancy {

/// A cube map of one scan, which indexes its beams by direction, so that the beams through a given voxel are found
/// without looking at all of them. It has six square images around the sensor; each pixel holds one of the beams that
/// fall into it. A second cube map at a quarter of the resolution serves near voxels, which cover many fine pixels.
/// Directions are those of the LiDAR frame L.
class BeamImage {
 public:
  /// Draws the beams with ranges between nearest_m and farthest_m. Longer beams count as farthest_m long if
  /// `use_farther` is set and are left out otherwise. The caller keeps the points in place as long as beams are looked
  /// up. Of several beams in a pixel the first is kept in one scan and the last in the next, so that no beam is always
  /// hidden. A pixel has 20 bits for the number of a point, so of more than 2^20 points only every second (third, ...)
  /// one is drawn.
  void build(const float* points, std::size_t n, std::size_t stride, float nearest_m, float farthest_m,
             bool use_farther);

  /// The images as kernels::seen_octants() reads them. They are valid until the next build().
  kernels::BeamImages images() const { return {fine_.data(), coarse_.data(), points_, stride_, steps_per_m_}; }
  /// The length in metres at which longer beams are cut.
  float longest_m() const { return farthest_m_; }
  std::size_t memory_bytes() const { return (fine_.capacity() + coarse_.capacity()) * sizeof(kernels::BeamPixel); }

 private:
  void keep(kernels::BeamPixel beam, std::int32_t fine, std::int32_t coarse);

  const float* points_ = nullptr;
  std::size_t stride_ = 3;
  float farthest_m_ = 0.0f;
  float steps_per_m_ = 0.0f;  ///< range steps of a pixel per metre
  bool is_first_kept_ = false;
  std::vector<kernels::BeamPixel> fine_, coarse_;
};

}  // namespace voxnav::occupancy
