// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"
#include "voxnav/planning/occupancy_view.hpp"

namespace voxnav::planning {

struct ClearanceFieldConfig {
  double safety_distance_m = 1.0;
  double radius_m = 2.0;
  double unknown_radius_m = 2.0;
  bool unknown_is_flyable = false;
  double max_memory_mib = 1024.0;

  template <class V>
  static void fields(V&& v) {
    v("safety_distance_m", &ClearanceFieldConfig::safety_distance_m, base::in(0.0, 10.0), "m",
      "voxels nearer than this to occupied ones are not flyable");
    v("radius_m", &ClearanceFieldConfig::radius_m, base::in(0.0, 20.0), "m",
      "distances to occupied voxels are kept up to this one, or up to 16 voxels if that is less");
    v("unknown_radius_m", &ClearanceFieldConfig::unknown_radius_m, base::in(0.0, 20.0), "m",
      "distances to unknown voxels are kept up to this one, or to safety_distance_m if that is more; 16 voxels at "
      "most");
    v("unknown_is_flyable", &ClearanceFieldConfig::unknown_is_flyable, base::any(), "",
      "parts of flyable space are connected through unknown voxels as well");
    v("max_memory_mib", &ClearanceFieldConfig::max_memory_mib, base::in(1.0, 65536.0), "MiB",
      "memory at most; a map that needs more is refused");
  }
  std::vector<std::string> problems() const;
};

/// What one update of a field did.
struct ClearanceUpdate {
  std::size_t changed_blocks = 0;     ///< blocks whose voxels differ from those of the last update
  std::size_t recomputed_blocks = 0;  ///< blocks whose distances or flyable voxels were computed again
};

/// How far the voxels of a map are from occupied and from unknown ones, exactly up to a radius, and which of them are
/// connected by flight: what the planner asks for instead of computing it in each search. An update recomputes only
/// what changed blocks can reach. A voxel is flyable if it is known to be free (or unknown, if the configuration says
/// so), inside the bounds of the view, not forbidden by it, and the safety distance away from occupied voxels; flyable
/// voxels are connected through faces, which is what a path that cuts no corner can pass. With unknown_is_flyable all
/// blocks of which nothing is known count as connected with each other. Not thread-safe; const calls may come from
/// several threads. Memory: about 22 KiB for each block of 16^3 voxels, bounded by max_memory_mib.
/// Source: Felzenszwalb & Huttenlocher, Theory of Computing 2012, section 2 (separable squared distances).
class ClearanceField {
 public:
  /// @throws base::ConfigError
  explicit ClearanceField(const ClearanceFieldConfig& config);
  ~ClearanceField();
  ClearanceField(ClearanceField&&) noexcept;
  ClearanceField& operator=(ClearanceField&&) noexcept;

  /// Takes over a map: all its blocks are compared with those of the last update. A view with other voxels than the
  /// last one starts the field anew. O(blocks) comparisons, then O(radius) operations for each voxel within reach of a
  /// change.
  /// @throws std::invalid_argument  if safety_distance_m is more than 16 voxels of the view
  /// @throws std::length_error      if the map needs more than max_memory_mib; the field is empty then
  ClearanceUpdate update(const OccupancyView& view);
  /// As update(), for a view that differs from the last one in the listed blocks and in its bounds at most.
  ClearanceUpdate update(const OccupancyView& view, const std::vector<geometry::Index3>& changed_blocks);

  /// Returns the exact distance from a point to the nearest occupied voxel, radius_m if none is nearer; NaN for points
  /// that are not finite. O((distance / resolution)^2).
  double clearance(const geometry::Vec3& point) const;
  /// Returns the number of the connected part of flyable space that holds a point, 0 if it is in none. Numbers begin
  /// at 1 and hold until the next update.
  std::uint32_t component(const geometry::Vec3& point) const;
  /// Squared distances from a voxel's centre to the nearest face of an occupied or an unknown voxel, in units of a
  /// quarter of a squared voxel edge, hence integers; kFar beyond the radius that is kept.
  int squared_to_occupied(const geometry::Index3& voxel) const;
  int squared_to_unknown(const geometry::Index3& voxel) const;
  static constexpr int kFar = 16000;

  const ClearanceFieldConfig& config() const;
  /// Edge of a voxel of the last view, 0 before the first update.
  double resolution_m() const;
  std::size_t num_blocks() const;
  std::size_t memory_bytes() const;

  class Impl;
  const Impl& impl() const { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace voxnav::planning
