// SPDX-License-Identifier: BSD-3-Clause
#include "submap/merged/point_placer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "submap/voxel_walk.hpp"

namespace voxnav::submap {

using geometry::Index3;
using geometry::kBlockSide;
using geometry::Vec3;

PointPlacer::PointPlacer(const std::vector<Eigen::Affine3d>& T_W_G, PlacedPoints* points)
    : frames_(T_W_G.size()), points_(points) {
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    frames_[i].T_W_G = T_W_G[i];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double step = T_W_G[i].linear()(static_cast<int>(k), static_cast<int>(axis));
        frames_[i].steps[axis][k] = fixed_units(step / kUnitsPerEdge);
      }
    }
  }
}

void PointPlacer::enter(const Index3& block_G) {
  constexpr double kRounding = 1e-6;  // far above the error of the fixed-point numbers
  constexpr double kArc = 1.0;        // how far a rotation leads off the straight line between two sampled times
  constexpr std::size_t kEvery = 32;  // every how many of the 256 times are sampled
  corner_G_ = Vec3(block_G.x, block_G.y, block_G.z) * kBlockSide;
  Vec3 lowest = Vec3::Constant(std::numeric_limits<double>::infinity()), highest = -lowest;
  for (std::size_t i = 0; i < frames_.size();
       i = i + 1 == frames_.size() ? i + 1 : std::min(i + kEvery, frames_.size() - 1)) {
    const Vec3 corner = frames_[i].T_W_G * corner_G_;
    const Eigen::Matrix3d side = frames_[i].T_W_G.linear() * kBlockSide;
    lowest = lowest.cwiseMin(corner + side.cwiseMin(0.0).rowwise().sum());
    highest = highest.cwiseMax(corner + side.cwiseMax(0.0).rowwise().sum());
  }
  const Vec3 margin = Vec3::Constant(frames_.size() > 1 ? kArc : kRounding);
  first_W_ = geometry::block_of(floor_index(lowest - margin));
  sides_ = geometry::block_of(floor_index(highest + margin)) - first_W_ + Index3{1, 1, 1};
  const auto length = [](std::int32_t side) { return static_cast<std::size_t>(side); };
  numbers_.assign(length(sides_.x) * length(sides_.y) * length(sides_.z), -1);
  ++num_entered_;
}

const PointPlacer::Frame& PointPlacer::frame_at(std::uint8_t time) {
  Frame& frame = frames_[frames_.size() > 1 ? time : 0];
  if (frame.entered != num_entered_) {
    const Vec3 from_first = frame.T_W_G * corner_G_ - Vec3(first_W_.x, first_W_.y, first_W_.z) * kBlockSide;
    for (std::size_t k = 0; k < 3; ++k) frame.origin[k] = fixed_units(from_first[static_cast<int>(k)]);
    frame.entered = num_entered_;
  }
  return frame;
}

std::int32_t PointPlacer::number_of(const Index3& step) {
  const std::int32_t position = step.x + sides_.x * (step.y + sides_.y * step.z);
  std::int32_t& number = numbers_[static_cast<std::size_t>(position)];
  if (number < 0) number = static_cast<std::int32_t>(points_->block(first_W_ + step));
  return number;
}

void PointPlacer::place(int offset, std::uint8_t time, SurfaceEvidence* next) {
  std::array<std::int8_t, 3>& mean = next->point.mean;
  const std::int64_t x = units_of(offset & 15, mean[0]);
  const std::int64_t y = units_of((offset >> 4) & 15, mean[1]);
  const std::int64_t z = units_of(offset >> 8, mean[2]);
  const Frame& frame = frame_at(time);
  std::array<int, 3> voxel;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::int64_t at = frame.origin[k] + x * frame.steps[0][k] + y * frame.steps[1][k] + z * frame.steps[2][k];
    voxel[k] = static_cast<int>(voxel_at(at));
    const auto rounded = static_cast<int>((at + (std::int64_t{1} << (kUnitShift - 1))) >> kUnitShift);
    mean[k] = static_cast<std::int8_t>(rounded - voxel[k] * kUnitsPerEdge - kUnitsPerEdge / 2);
  }
  const auto offset_W = static_cast<std::uint16_t>(geometry::offset_in_block({voxel[0], voxel[1], voxel[2]}));
  next->offset = offset_W;
  const std::int32_t number = number_of(geometry::block_of({voxel[0], voxel[1], voxel[2]}));
  points_->add_next(static_cast<std::uint32_t>(number), offset_W, time);
}

}  // namespace voxnav::submap
