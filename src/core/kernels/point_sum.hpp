// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace voxnav::kernels {

/// Sums of points and of the products of their coordinates, from which mean and covariance follow.
struct PointSum {
  /// Four numbers in the compiler's vector type: a row is built in a register, where an array would be written to
  /// memory first.
  using Row = float __attribute__((vector_size(16)));
  Row first{};   ///< x y z 1
  Row second{};  ///< xx xy xz x
  Row third{};   ///< xy yy yz y
  float zz = 0.0f;

  void add(float x, float y, float z) {
    const Row row{x, y, z, 1.0f};
    first += row;
    second += x * row;
    third += y * row;
    zz += z * z;
  }
  void add(const PointSum& other) {
    first += other.first;
    second += other.second;
    third += other.third;
    zz += other.zz;
  }
};

namespace reference {

struct PointSum {
  float count = 0, x = 0, y = 0, z = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  void add(float px, float py, float pz) {
    count += 1.0f;
    x += px;
    y += py;
    z += pz;
    xx += px * px;
    xy += px * py;
    xz += px * pz;
    yy += py * py;
    yz += py * pz;
    zz += pz * pz;
  }
};

}  // namespace reference
}  // namespace voxnav::kernels
