// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <unordered_map>
#include <vector>

#include "flights.hpp"
#include "voxnav/geometry/voxel.hpp"

namespace voxnav::benchmark {

/// The accuracy with which a map holds the surfaces that were measured.
struct Quality {
  struct Share {
    std::size_t cells = 0;
    std::size_t kept = 0;          ///< cells with a probability above 0.5
    std::size_t wrongly_free = 0;  ///< cells with a probability below the free threshold
    double kept_share() const { return cells == 0 ? 1.0 : static_cast<double>(kept) / static_cast<double>(cells); }
    double free_share() const {
      return cells == 0 ? 0.0 : static_cast<double>(wrongly_free) / static_cast<double>(cells);
    }
  };
  Share all;
  std::array<Share, voxnav_simulation::kNumSurfaceClasses> by_class;
  double phantom = 0.0;  ///< share of occupied voxels without surface within one voxel
  double rms_m = 0.0;    ///< root mean square distance of surface points from the true surface
};

/// The voxels with true surface points, and how often scans of a flight saw each.
class SurfaceCells {
 public:
  explicit SurfaceCells(double resolution_m) : resolution_m_(resolution_m) {}
  void add(const FlightScan& scan, double max_range_m);

  /// Returns the probability that a place is occupied, or nothing where the map knows nothing.
  using Probability = std::function<std::optional<double>(const geometry::Vec3&)>;
  /// Judges a map on all cells that were seen in at least `least_scans` scans.
  Quality judge(const Probability& probability, double free_threshold, int least_scans) const;
  double resolution_m() const { return resolution_m_; }

 private:
  struct Cell {
    int scans = 0;
    int last_scan = -1;
    std::uint8_t surface_class = 0;
  };
  double resolution_m_;
  int num_scans_ = 0;
  std::unordered_map<geometry::Index3, Cell, geometry::Index3Hash> cells_;
};

/// Returns the share of voxel centres (rows of x, y, z) with no surface within one voxel.
double phantom_share(const std::vector<float>& centers, double resolution_m, const voxnav_simulation::Scene& scene);
/// Returns the root mean square distance of points (rows of x, y, z) from the surface, without the phantoms that
/// phantom_share() counts.
double rms_distance(const std::vector<float>& points, double resolution_m, const voxnav_simulation::Scene& scene);

}  // namespace voxnav::benchmark
