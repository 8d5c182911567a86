// SPDX-License-Identifier: BSD-3-Clause
#include "base/check.hpp"
#include "voxnav/planning/occupancy_view.hpp"

namespace voxnav::planning {

geometry::Aabb bounds_of(const containers::StateGrid& grid) {
  geometry::Aabb out;
  const double side_m = geometry::kBlockSide * grid.resolution_m();
  for (const auto& entry : grid.blocks()) {
    const geometry::Vec3 corner = geometry::Vec3(entry.first.x, entry.first.y, entry.first.z) * side_m;
    out.extend(corner);
    out.extend(corner + geometry::Vec3::Constant(side_m));
  }
  return out;
}

StateGridView::StateGridView(std::shared_ptr<const containers::StateGrid> grid, double grown_by_m)
    : grid_(std::move(grid)), grown_by_m_(grown_by_m) {
  VOXNAV_CHECK(grid_ != nullptr, "a view needs a grid");
  bounds_ = bounds_of(*grid_);
}

}  // namespace voxnav::planning
