// SPDX-License-Identifier: BSD-3-Clause
#include "kernels/neighborhood.hpp"

#include "kernels/bits.hpp"
#include "kernels/lanes.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::kernels {
namespace {

using namespace lanes;  // NOLINT: the vector types of this file

using Quad = float __attribute__((vector_size(16)));

/// Table of sums over three neighbouring voxels of a row: the sum of the unit vectors to the free ones, and their
/// number, for each of the nine rows around a voxel and each combination of free voxels.
using RowSums = std::array<std::array<std::array<float, 4>, 8>, 9>;
RowSums make_sums() {
  RowSums out;
  for (int row = 0; row < 9; ++row) {
    for (int bits = 0; bits < 8; ++bits) {
      Eigen::Vector4f sum = Eigen::Vector4f::Zero();
      for (int k = 0; k < 3; ++k) {
        const int y = row % 3 - 1, z = row / 3 - 1;
        const geometry::Vec3f step(static_cast<float>(k - 1), static_cast<float>(y), static_cast<float>(z));
        if (((bits >> k) & 1) && !step.isZero()) sum += step.normalized().homogeneous();
      }
      out[static_cast<std::size_t>(row)][static_cast<std::size_t>(bits)] = {sum[0], sum[1], sum[2], sum[3]};
    }
  }
  return out;
}
const RowSums& row_sums() {
  static const RowSums sums = make_sums();
  return sums;
}

/// Lists the occupied neighbours first and sums their points then, which needs only one branch.
VOXNAV_INLINE void look(const VoxelWindow& window, const geometry::Index3& voxel, const RowSums& sums,
                        Neighborhood* out) {
  constexpr unsigned kCount[8] = {0, 1, 1, 2, 1, 2, 2, 3};
  unsigned others[27 + 3];
  unsigned num_others = 0;
  Quad towards_free{};
  const int shift = voxel.x - 1 + kWindowHalo;
  for (int row = 0; row < 9; ++row) {
    const std::size_t at = VoxelWindow::row(voxel.y + row % 3 - 1, voxel.z + row / 3 - 1);
    towards_free += loaded<Quad>(&sums[static_cast<std::size_t>(row)][(window.free_rows[at] >> shift) & 7u]);
    const std::uint32_t occupied = window.occupied_rows[at];
    const unsigned first = window.first_of_row[at] + count_bits(occupied & ((1u << shift) - 1u));
    for (unsigned k = 0; k < 3; ++k) others[num_others + k] = first + k;
    num_others += kCount[(occupied >> shift) & 7u];
  }
  const auto x = static_cast<float>(voxel.x), y = static_cast<float>(voxel.y), z = static_cast<float>(voxel.z);
  const Quad center = {x, y, z, 0.f}, turned_center = {y, z, x, 0.f};
  Quad sum{}, squares{}, products{};
  for (unsigned i = 0; i < num_others; ++i) {
    const WindowPoint& point = window.points[others[i]];
    const Quad p = loaded<Quad>(point.data()) - center;
    sum += p;
    squares += p * p;
    products += p * (loaded<Quad>(point.data() + 4) - turned_center);
  }
  store(towards_free, out->towards_free.data());
  store(sum, out->sum.data());
  store(squares, out->squares.data());
  store(products, out->products.data());
}

VOXNAV_INLINE void look_all(const VoxelWindow& window, const std::array<geometry::Index3, kTogether>& voxels,
                            const RowSums& sums, NeighborhoodBatch* out) {
  for (std::size_t k = 0; k < kTogether; ++k) look(window, voxels[k], sums, &(*out)[k]);
}
void look_plain(const VoxelWindow& window, const std::array<geometry::Index3, kTogether>& voxels, const RowSums& sums,
                NeighborhoodBatch* out) {
  look_all(window, voxels, sums, out);
}
VOXNAV_WIDE void look_wide(const VoxelWindow& window, const std::array<geometry::Index3, kTogether>& voxels,
                           const RowSums& sums, NeighborhoodBatch* out) {
  look_all(window, voxels, sums, out);
}

}  // namespace

void look_around(const VoxelWindow& window, const std::array<geometry::Index3, kTogether>& voxels,
                 NeighborhoodBatch* out) {
  (is_wide() ? look_wide : look_plain)(window, voxels, row_sums(), out);
}

Neighborhood reference::look_around(const VoxelWindow& window, const geometry::Index3& voxel) {
  Neighborhood out{};
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      std::array<float, 4> row{};
      std::size_t number = window.first_of_row[VoxelWindow::row(voxel.y + dy, voxel.z + dz)];
      for (int x = -kWindowHalo; x <= voxel.x + 1; ++x) {
        const auto is_set = [&](std::uint32_t bits) { return ((bits >> (x + kWindowHalo)) & 1u) != 0; };
        const bool is_occupied = is_set(window.occupied(voxel.y + dy, voxel.z + dz));
        const int dx = x - voxel.x;
        if (dx >= -1 && is_set(window.free(voxel.y + dy, voxel.z + dz)) && (dx != 0 || dy != 0 || dz != 0)) {
          const geometry::Vec3f way =
              geometry::Vec3f(static_cast<float>(dx), static_cast<float>(dy), static_cast<float>(dz)).normalized();
          for (std::size_t k = 0; k < 3; ++k) row[k] += way[static_cast<Eigen::Index>(k)];
          row[3] += 1.0f;
        }
        if (dx >= -1 && is_occupied) {
          const WindowPoint& point = window.points[number];
          const float p[3] = {point[0] - static_cast<float>(voxel.x), point[1] - static_cast<float>(voxel.y),
                              point[2] - static_cast<float>(voxel.z)};
          for (std::size_t k = 0; k < 3; ++k) {
            out.sum[k] += p[k];
            out.squares[k] += p[k] * p[k];
            out.products[k] += p[k] * p[(k + 1) % 3];
          }
          out.sum[3] += 1.0f;
        }
        number += is_occupied ? 1 : 0;
      }
      for (std::size_t k = 0; k < 4; ++k) out.towards_free[k] += row[k];
    }
  }
  return out;
}

}  // namespace voxnav::kernels
