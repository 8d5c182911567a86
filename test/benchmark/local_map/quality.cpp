// SPDX-License-Identifier: BSD-3-Clause
#include "quality.hpp"

#include <cmath>

namespace voxnav::benchmark {

using geometry::Vec3;

void SurfaceCells::add(const FlightScan& scan, double max_range_m) {
  for (std::size_t i = 0; i < scan.true_points_W.size(); ++i) {
    const Vec3 p = scan.true_points_W[i].cast<double>();
    if ((p - scan.T_W_L.translation()).norm() > max_range_m) continue;
    Cell& cell = cells_[geometry::index_of(p, resolution_m_)];
    if (cell.last_scan == num_scans_) continue;
    if (cell.scans == 0) cell.surface_class = scan.classes[i];
    cell.last_scan = num_scans_;
    ++cell.scans;
  }
  ++num_scans_;
}

Quality SurfaceCells::judge(const Probability& probability, double free_threshold, int least_scans) const {
  Quality out;
  for (const auto& [index, cell] : cells_) {
    if (cell.scans < least_scans) continue;
    const std::optional<double> p = probability(geometry::center_of(index, resolution_m_));
    for (Quality::Share* share : {&out.all, &out.by_class[cell.surface_class]}) {
      ++share->cells;
      share->kept += p && *p > 0.5 ? 1 : 0;
      share->wrongly_free += p && *p < free_threshold ? 1 : 0;
    }
  }
  return out;
}

double phantom_share(const std::vector<float>& centers, double resolution_m, const voxnav_simulation::Scene& scene) {
  // The ball around the centre lies within the neighbouring voxels, so that this is stricter than a search in them.
  const double reach = 1.5 * resolution_m;
  std::size_t phantoms = 0;
  for (std::size_t i = 0; i < centers.size(); i += 3) {
    phantoms += scene.clearance(Vec3(centers[i], centers[i + 1], centers[i + 2]), reach) >= reach ? 1 : 0;
  }
  return centers.empty() ? 0.0 : 3.0 * static_cast<double>(phantoms) / static_cast<double>(centers.size());
}

double rms_distance(const std::vector<float>& points, double resolution_m, const voxnav_simulation::Scene& scene) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < points.size(); i += 3) {
    const double d = scene.clearance(Vec3(points[i], points[i + 1], points[i + 2]), 1.5 * resolution_m);
    if (d >= 1.5 * resolution_m) continue;
    sum += d * d;
    ++count;
  }
  return count == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(count));
}

}  // namespace voxnav::benchmark
