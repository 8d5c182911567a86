// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "voxnav/geometry/pose.hpp"

namespace voxnav::geometry {

/// A non-owning view of points, each a row of floats that begins with x, y, z, so that arrays of any point type are
/// read (and transformed) in place. The view must not outlive the points. The function that takes a view defines the
/// frame of the points.
template <class Float>
class BasicPointsView {
 public:
  /// Makes a view of no points.
  BasicPointsView() = default;
  /// @param first             x of the first point; may be null if there are no points
  /// @param floats_per_point  number of floats from one x to the next
  /// @throws std::invalid_argument if a point has fewer than three floats
  BasicPointsView(Float* first, std::size_t size, std::size_t floats_per_point)
      : first_(first), size_(size), floats_per_point_(floats_per_point) {
    if (floats_per_point < 3) throw std::invalid_argument("points need at least x, y, z");
  }
  /// A view of mutable points converts to one of constant points.
  template <class Other, class = std::enable_if_t<std::is_same_v<const Other, Float>>>
  BasicPointsView(const BasicPointsView<Other>& other)  // NOLINT(google-explicit-constructor): the same points
      : first_(other.data()), size_(other.size()), floats_per_point_(other.floats_per_point()) {}

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  std::size_t floats_per_point() const { return floats_per_point_; }
  Float* data() const { return first_; }
  Eigen::Map<std::conditional_t<std::is_const_v<Float>, const Vec3f, Vec3f>> operator[](std::size_t i) const {
    return Eigen::Map<std::conditional_t<std::is_const_v<Float>, const Vec3f, Vec3f>>(first_ + i * floats_per_point_);
  }
  /// Returns the view of `count` points from number `begin` on; all of them must lie within this view.
  BasicPointsView part(std::size_t begin, std::size_t count) const {
    return {count == 0 ? first_ : first_ + begin * floats_per_point_, count, floats_per_point_};
  }

 private:
  Float* first_ = nullptr;
  std::size_t size_ = 0;
  std::size_t floats_per_point_ = 3;
};

using PointsView = BasicPointsView<const float>;
using MutablePointsView = BasicPointsView<float>;

inline PointsView view_of(const std::vector<Vec3f>& points) {
  return {points.empty() ? nullptr : points.front().data(), points.size(), 3};
}

/// Makes a view of an array of x, y, z rows, such as LocalMap::occupied_points() returns.
inline PointsView view_of_rows(const std::vector<float>& xyz) { return {xyz.data(), xyz.size() / 3, 3}; }
inline MutablePointsView view_of_rows(std::vector<float>* xyz) { return {xyz->data(), xyz->size() / 3, 3}; }

}  // namespace voxnav::geometry
