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

/// How faithfully a map holds the surfaces that were measured.
struct Quality {
  struct Share {
    std::size_t cells = 0;
    std::size_t kept = 0;          ///< p above 0.5
    std::size_t wrongly_free = 0;  ///< p below the free threshold
    double kept_share() const { return cells == 0 ? 1.0 : static_cast<double>(kept) / static_cast<double>(cells); }
    double free_share() const {
      return cells == 0 ? 0.0 : static_cast<double>(wrongly_free) / static_cast<double>(cells);
    }
  };
  Share all;
  std::array<Share, voxnav_simulation::kNumSurfaceClasses> by_class;
  double phantom = 0.0;  ///< share of occupied voxels without surface within one voxel
  double rms_m = 0.0;    ///< of surface points from the true surface
};

/// Voxels that hold true surface points, counted over a flight.
class SurfaceCells {
 public:
  explicit SurfaceCells(double resolution_m) : resolution_m_(resolution_m) {}
  void add(const FlightScan& scan, double max_range_m);

  /// Probability of occupied at a place; none where the map knows nothing.
  using Probability = std::function<std::optional<double>(const geometry::Vec3&)>;
  /// Over all cells that were seen in at least `least_scans` scans.
  Quality judge(const Probability& probability, double free_threshold, int least_scans) const;
  double resolution_m() const { return resolution_m_; }

 private:
  struct Cell {
    int scans = 0;
    int last_scan = -1;
    std::uint8_t surface_class = 0;
  };
  struct Hash {
    std::size_t operator()(const geometry::Index3& i) const {
      return static_cast<std::size_t>(i.x * 73856093) ^ static_cast<std::size_t>(i.y * 19349663) ^
             static_cast<std::size_t>(i.z * 83492791);
    }
  };
  double resolution_m_;
  int num_scans_ = 0;
  std::unordered_map<geometry::Index3, Cell, Hash> cells_;
};

/// Share of voxel centres (x y z rows) with no surface within one voxel of theirs.
double phantom_share(const std::vector<float>& centers, double resolution_m, const voxnav_simulation::Scene& scene);
/// Root mean square distance of points (x y z rows) from the surface; phantoms are left to phantom_share().
double rms_distance(const std::vector<float>& points, double resolution_m, const voxnav_simulation::Scene& scene);

}  // namespace voxnav::benchmark
