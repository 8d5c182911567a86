// SPDX-License-Identifier: BSD-3-Clause
#include "submap/merged/free_window.hpp"

#include <algorithm>
#include <cmath>

#include "kernels/column_rows.hpp"
#include "submap/voxel_walk.hpp"

namespace voxnav::submap {

using geometry::Index3;
using geometry::kBlockSide;
using geometry::Vec3;

// The corner of the window lies at the border of a block along x, so that rows of blocks are copied to its rows whole.
std::array<Index3, 2> FreeWindow::place(const Eigen::Affine3d& T_G_W, const Index3& block_W) {
  constexpr double kRounding = 1e-6;  // far above the rounding of the integers
  const Vec3 corner = T_G_W * Vec3(Vec3(block_W.x, block_W.y, block_W.z) * kBlockSide);
  const Vec3 side_x = T_G_W.linear().col(0) * kBlockSide;
  const Vec3 side_y = T_G_W.linear().col(1) * kBlockSide;
  Vec3 low = corner + side_x.cwiseMin(0.0) + side_y.cwiseMin(0.0);
  Vec3 high = corner + side_x.cwiseMax(0.0) + side_y.cwiseMax(0.0);
  low.z() = corner.z() - 1.0;
  high.z() = corner.z() + kBlockSide;
  const std::array<Index3, 2> touched = {floor_index(low - Vec3::Constant(kRounding)),
                                         floor_index(high + Vec3::Constant(kRounding))};
  low_ = {touched[0].x & ~(kBlockSide - 1), touched[0].y, touched[0].z};
  num_rows_ = touched[1].y - low_.y + 1;
  std::fill_n(columns_.begin(), num_rows_ * kRowLength, 0u);
  origin_ = {fixed_units(corner.x() - low_.x), fixed_units(corner.y() - low_.y), fixed_units(corner.z() - low_.z)};
  const auto fixed = [](double edges) {
    return static_cast<std::int32_t>(std::lround(std::ldexp(edges, kCenterShift)));
  };
  const Vec3 center = T_G_W * geometry::center_of(geometry::voxel_at(block_W, 0), 1.0);
  center_ = {fixed(center.x() - low_.x), fixed(center.y() - low_.y)};
  right_ = {fixed(T_G_W.linear()(0, 0)), fixed(T_G_W.linear()(1, 0))};
  back_ = {fixed(T_G_W.linear()(0, 1)), fixed(T_G_W.linear()(1, 1))};
  const Eigen::Matrix3d step = T_G_W.linear() / kUnitsPerEdge;
  along_x_ = {fixed_units(step(0, 0)), fixed_units(step(1, 0))};
  along_y_ = {fixed_units(step(0, 1)), fixed_units(step(1, 1))};
  return touched;
}

void FreeWindow::take(const Index3& block_G, const Columns& free) {
  const Index3 first = geometry::voxel_at(block_G, 0) - low_;  // relative to the window
  const int first_row = std::max(0, first.y);
  kernels::ColumnRows rows;
  rows.from = &free[column_at(0, first_row - first.y)];
  rows.to = columns_.data() + (first_row * kRowLength + first.x);
  rows.row_length = kRowLength;
  rows.count = std::min(num_rows_, first.y + kBlockSide) - first_row;
  rows.up = first.z;
  kernels::add_rows(rows);
}

void FreeWindow::add_to(Columns* free) const {
  constexpr std::int64_t kHalf = kUnitsPerEdge / 2;
  const std::uint32_t lowest = voxel_at(origin_.z + (kHalf << kUnitShift));
  kernels::add_turned_columns(columns_.data(), kRowLength, {center_, right_, back_, kCenterShift, lowest},
                              free->data());
}

}  // namespace voxnav::submap
