// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/ray_marks.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "voxnav/occupancy/byte_ops.hpp"

namespace voxnav::occupancy {
namespace {

constexpr int kSide = geometry::kBlockSide;
constexpr int kShift = geometry::kBlockShift;

/// Fixed point with 32 fractional bits: exact to 10^-7 of a voxel over the longest ray, and compared in one cycle.
constexpr int kFraction = 32;
constexpr double kOne = 4294967296.0;
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max() / 4;
constexpr double kMostPerCell = 1 << 20;  ///< longer than any ray

std::int64_t fixed(double x) { return static_cast<std::int64_t>(x * kOne); }

}  // namespace

void RayMarks::RowTable::build(int num_blocks, std::uint32_t block_stride, std::uint32_t inside) {
  const int cells = num_blocks * kSide;
  rows_.resize(static_cast<std::size_t>(cells) + 2);
  for (int cell = -1; cell <= cells; ++cell) {
    const int at = std::clamp(cell, 0, cells - 1);
    rows_[static_cast<std::size_t>(cell + 1)] =
        static_cast<std::uint32_t>(at >> kShift) * block_stride + static_cast<std::uint32_t>(at & (kSide - 1)) * inside;
  }
}

/// The way of a ray across one of its two shorter axes, seen from the longest one: where it changes voxel.
struct RayMarks::ShortAxis {
  const RowTable& rows;
  int cell;
  int step;               ///< +1 or -1
  std::int64_t next;      ///< fixed-point coordinate on the longest axis at which the next change comes
  std::int64_t per_cell;  ///< between changes

  std::uint32_t row() const { return rows[cell]; }
  /// Takes the next change if `use`; written without branches, which nobody could predict.
  void advance(bool use) {
    const std::int64_t mask = -static_cast<std::int64_t>(use);
    cell += step & static_cast<int>(mask);
    next += per_cell & mask;
  }
};

inline RayMarks::ShortAxis RayMarks::short_axis(int axis, const RowTable& rows, int a, const geometry::Vec3& from,
                                                const geometry::Vec3& to) const {
  const double way = to[axis] - from[axis];
  ShortAxis out{rows, static_cast<int>(from[axis]), way < 0.0 ? -1 : 1, kNever, 0};
  if (static_cast<int>(to[axis]) == out.cell) return out;
  const double per_cell = (to[a] - from[a]) / std::abs(way);
  const double first = way > 0.0 ? out.cell + 1 - from[axis] : from[axis] - out.cell;
  out.next = fixed(std::min(from[a] + first * per_cell, kMostPerCell));
  out.per_cell = fixed(std::min(per_cell, kMostPerCell));
  return out;
}

void RayMarks::begin(const ScanBox& box) {
  box_ = &box;
  for (Image& image : images_) {
    image.rows.resize(std::max<std::size_t>(image.rows.size(), kRows * box.num_blocks()));
    image.crossed.resize(image.rows.size() / kRows);
  }
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const auto stride = static_cast<std::uint32_t>(kRows * box.block_stride(axis));
    second_[i].build(static_cast<int>(box.size(axis)), stride, 1);
    third_[i].build(static_cast<int>(box.size(axis)), stride, kSide);
  }
}

/// Voxels first to last of a row along the longest axis.
inline void RayMarks::mark_run(Image* image, std::uint32_t block_stride, std::uint32_t row, int first, int last) {
  const auto mark = [&](int block, int low, int high) {
    const std::uint32_t at = row + static_cast<std::uint32_t>(block) * block_stride;
    image->rows[at] = static_cast<std::uint16_t>(image->rows[at] | ((2u << high) - (1u << low)));
    image->crossed[at / kRows] = 1;
  };
  int block = first >> kShift, low = first & (kSide - 1);
  for (; block < last >> kShift; ++block, low = 0) mark(block, low, kSide - 1);
  mark(block, low, last & (kSide - 1));
}

void RayMarks::cast(const geometry::Vec3f& end, const geometry::Vec3& origin) {
  const geometry::Vec3 corner = box_->corner();
  geometry::Vec3 from = end.cast<double>() - corner;
  geometry::Vec3 to = origin - corner;
  int a = 0;
  (to - from).cwiseAbs().maxCoeff(&a);
  if (from[a] > to[a]) std::swap(from, to);
  const int second = (a + 1) % 3, third = (a + 2) % 3;
  ShortAxis b = short_axis(second, second_[static_cast<std::size_t>(second)], a, from, to);
  ShortAxis c = short_axis(third, third_[static_cast<std::size_t>(third)], a, from, to);
  const auto stride = static_cast<std::uint32_t>(kRows * box_->block_stride(a));
  Image* image = &images_[static_cast<std::size_t>(a)];
  const std::int64_t last_change = fixed(to[a]);
  int at = static_cast<int>(from[a]);
  const int last = static_cast<int>(to[a]);
  while (true) {
    const bool is_b = b.next <= c.next;
    const std::int64_t next = is_b ? b.next : c.next;
    if (next >= last_change) break;
    const auto stop = static_cast<int>(next >> kFraction);
    mark_run(image, stride, b.row() + c.row(), at, stop);
    b.advance(is_b);
    c.advance(!is_b);
    at = stop;
  }
  mark_run(image, stride, b.row() + c.row(), at, last);
  // Where rounding has put the last change behind the end.
  b.cell = static_cast<int>(to[second]);
  c.cell = static_cast<int>(to[third]);
  mark_run(image, stride, b.row() + c.row(), last, last);
}

void RayMarks::add_to(std::uint32_t block, VoxelBits* bits) const {
  const auto rows = [&](int axis) { return images_[axis].rows.data() + kRows * block; };
  if (images_[0].crossed[block] != 0) {
    // Rows along x are in the order of the voxels already.
    for (std::size_t i = 0; i < kRows; ++i) (*bits)[i / 4] |= std::uint64_t{rows(0)[i]} << (16 * (i % 4));
  }
  std::uint16_t turned[kSide];
  if (images_[1].crossed[block] != 0) {
    for (int z = 0; z < kSide; ++z) {
      if (!transpose_16(rows(1) + z, kSide, turned)) continue;
      for (int y = 0; y < kSide; ++y) (*bits)[4 * z + y / 4] |= std::uint64_t{turned[y]} << (16 * (y % 4));
    }
  }
  if (images_[2].crossed[block] != 0) {
    for (int y = 0; y < kSide; ++y) {
      if (!transpose_16(rows(2) + y * kSide, 1, turned)) continue;
      for (int z = 0; z < kSide; ++z) (*bits)[4 * z + y / 4] |= std::uint64_t{turned[z]} << (16 * (y % 4));
    }
  }
}

void RayMarks::clear(std::uint32_t block) {
  for (Image& image : images_) {
    if (image.crossed[block] == 0) continue;
    image.crossed[block] = 0;
    std::fill_n(image.rows.begin() + static_cast<std::ptrdiff_t>(kRows * block), kRows, std::uint16_t{0});
  }
}

std::size_t RayMarks::memory_bytes() const {
  std::size_t bytes = 0;
  for (const Image& image : images_) bytes += image.rows.capacity() * sizeof(std::uint16_t) + image.crossed.capacity();
  return bytes;
}

}  // namespace voxnav::occupancy
