// SPDX-License-Identifier: BSD-3-Clause
#include "leaf_placer.hpp"

#include <algorithm>
#include <cmath>

#include "voxnav/submap/voxel_walk.hpp"

namespace voxnav::submap {

using geometry::Index3;
using geometry::kBlockSide;
using geometry::Vec3;

LeafPlacer::LeafPlacer(const Eigen::Affine3d& T_W_G, PlacedLeaves* leaves) : T_W_G_(T_W_G), leaves_(leaves) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < 3; ++k) {
      steps_[axis][k] = fixed_units(T_W_G.linear()(static_cast<int>(k), static_cast<int>(axis)) / kUnitsPerEdge);
    }
  }
  const double extent = T_W_G.linear().cwiseAbs().rowwise().sum().maxCoeff();  // of a block, in blocks
  side_ = static_cast<int>(std::ceil(extent)) + 2;
  numbers_.resize(static_cast<std::size_t>(side_ * side_ * side_));
}

void LeafPlacer::enter(const Index3& block_G) {
  constexpr double kRounding = 1e-6;  // of the integers, by far
  const Vec3 corner = T_W_G_ * Vec3(Vec3(block_G.x, block_G.y, block_G.z) * kBlockSide);
  const Vec3 lowest = corner + (T_W_G_.linear() * kBlockSide).cwiseMin(0.0).rowwise().sum();
  first_W_ = geometry::block_of(floor_index(lowest - Vec3::Constant(kRounding)));
  const Vec3 from_first = corner - Vec3(first_W_.x, first_W_.y, first_W_.z) * kBlockSide;
  for (std::size_t k = 0; k < 3; ++k) origin_[k] = fixed_units(from_first[static_cast<int>(k)]);
  std::fill(numbers_.begin(), numbers_.end(), -1);
}

void LeafPlacer::place(int offset, const std::array<std::int8_t, 3>& mean, PlacedLeaf* next) {
  const std::int64_t x = units_of(offset & 15, mean[0]);
  const std::int64_t y = units_of((offset >> 4) & 15, mean[1]);
  const std::int64_t z = units_of(offset >> 8, mean[2]);
  std::array<int, 3> voxel;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::int64_t at = origin_[k] + x * steps_[0][k] + y * steps_[1][k] + z * steps_[2][k];
    voxel[k] = static_cast<int>(voxel_at(at));
    const auto rounded = static_cast<int>((at + (std::int64_t{1} << (kUnitShift - 1))) >> kUnitShift);
    next->mean[k] = static_cast<std::int8_t>(rounded - voxel[k] * kUnitsPerEdge - kUnitsPerEdge / 2);
  }
  const auto offset_W = static_cast<std::uint16_t>(geometry::offset_in_block({voxel[0], voxel[1], voxel[2]}));
  next->offset = offset_W;
  const Index3 step = geometry::block_of({voxel[0], voxel[1], voxel[2]});
  std::int32_t& number = numbers_[static_cast<std::size_t>(step.x + side_ * (step.y + side_ * step.z))];
  if (number < 0) number = static_cast<std::int32_t>(leaves_->block(first_W_ + step));
  leaves_->add_next(static_cast<std::uint32_t>(number), offset_W);
}

}  // namespace voxnav::submap
