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

/// The way of a ray across one of its two shorter axes, seen from the longest one: where it changes voxel.
struct ShortAxis {
  int cell;
  int step;                      ///< +1 or -1
  int num_left;                  ///< changes to come
  double next;                   ///< coordinate on the longest axis at which the next one comes
  double per_cell;               ///< between changes
  std::uint32_t stride, inside;  ///< of a block and of a voxel in row numbers

  ShortAxis(double from, double to, double slope, double start, std::uint32_t block_stride, std::uint32_t inside_stride)
      : cell(static_cast<int>(from)),
        step(slope < 0.0 ? -1 : 1),
        num_left(std::abs(static_cast<int>(to) - cell)),
        next(start),
        per_cell(0.0),
        stride(block_stride),
        inside(inside_stride) {
    if (num_left == 0) return;
    per_cell = 1.0 / std::abs(slope);
    next += std::abs(step > 0 ? cell + 1 - from : from - cell) * per_cell;
  }
  std::uint32_t row() const {
    return static_cast<std::uint32_t>(cell >> kShift) * stride +
           static_cast<std::uint32_t>(cell & (kSide - 1)) * inside;
  }
  /// Takes the next change if `use`; written without branches.
  void advance(bool use) {
    cell += use ? step : 0;
    next += use ? per_cell : 0.0;
    num_left -= use ? 1 : 0;
  }
};

}  // namespace

struct RayMarks::Line {
  std::uint32_t a_stride;  ///< row numbers from block to block along the longest axis
};

void RayMarks::begin(const ScanBox& box) {
  box_ = &box;
  for (Image& image : images_) {
    image.rows.resize(std::max<std::size_t>(image.rows.size(), kRows * box.num_blocks()));
    image.crossed.resize(image.rows.size() / kRows);
  }
}

/// Voxels first to last of a row along the longest axis.
inline void RayMarks::mark_run(Image* image, const Line& line, std::uint32_t row, int first, int last) {
  for (int block = first >> kShift; block <= last >> kShift; ++block) {
    const std::uint32_t at = row + static_cast<std::uint32_t>(block) * line.a_stride;
    const int low = std::max(first - block * kSide, 0), high = std::min(last - block * kSide, kSide - 1);
    image->rows[at] = static_cast<std::uint16_t>(image->rows[at] | ((2u << high) - (1u << low)));
    image->crossed[at / kRows] = 1;
  }
}

void RayMarks::cast(const geometry::Vec3f& end, const geometry::Vec3& origin) {
  const geometry::Vec3 corner = box_->corner();
  geometry::Vec3 from = end.cast<double>() - corner;
  geometry::Vec3 to = origin - corner;
  int a = 0;
  const double length = (to - from).cwiseAbs().maxCoeff(&a);
  if (from[a] > to[a]) std::swap(from, to);
  const double scale = length > 0.0 ? 1.0 / length : 0.0;
  const auto short_axis = [&](int axis, std::uint32_t inside) {
    return ShortAxis(from[axis], to[axis], (to[axis] - from[axis]) * scale, from[a],
                     static_cast<std::uint32_t>(kRows) * box_->block_stride(axis), inside);
  };
  ShortAxis b = short_axis((a + 1) % 3, 1);
  ShortAxis c = short_axis((a + 2) % 3, kSide);
  const Line line{static_cast<std::uint32_t>(kRows) * box_->block_stride(a)};
  Image* image = &images_[a];
  int at = static_cast<int>(from[a]);
  const int last = static_cast<int>(to[a]);
  for (int changes = b.num_left + c.num_left; changes > 0; --changes) {
    const bool is_b = (b.num_left > 0) & ((c.num_left == 0) | (b.next <= c.next));
    const int stop = std::max(at, std::min(last, static_cast<int>(is_b ? b.next : c.next)));
    mark_run(image, line, b.row() + c.row(), at, stop);
    b.advance(is_b);
    c.advance(!is_b);
    at = stop;
  }
  mark_run(image, line, b.row() + c.row(), at, last);
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
