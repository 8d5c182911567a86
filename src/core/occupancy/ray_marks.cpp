// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/ray_marks.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "kernels/bits.hpp"
#include "kernels/ray_walk.hpp"
#include "kernels/row_sets.hpp"

namespace voxnav::occupancy {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "words of a line are read as rows of 16 voxels");

constexpr int kSide = geometry::kBlockSide;
constexpr int kWord = 1 << kernels::ray_walk::kWordShift;

struct Axes {
  int a, b, c;
};
constexpr Axes axes_of(int face) { return {face / 2, face / 2 == 0 ? 1 : 0, face / 2 == 2 ? 1 : 2}; }

/// Returns the face that a ray leaves through. It is computed without branches, because a processor would mispredict
/// them: neighbouring rays often leave through different faces.
int face_through(const geometry::Vec3f& way) {
  const float x = std::abs(way.x()), y = std::abs(way.y()), z = std::abs(way.z());
  const bool is_x = (x >= y) & (x >= z), is_y = !is_x & (y >= z), is_z = !is_x & !is_y;
  const unsigned is_up = (is_x & (way.x() > 0.0f)) | (is_y & (way.y() > 0.0f)) | (is_z & (way.z() > 0.0f));
  return static_cast<int>(2u * is_y + 4u * is_z + is_up);
}

/// One slice of a block in an image: 16 rows of 16 voxels.
struct Rows {
  std::uint16_t row[kSide];
  bool load(const std::uint8_t* at, std::ptrdiff_t step) {
    unsigned any = 0;
    for (int i = 0; i < kSide; ++i, at += step) {
      std::memcpy(&row[i], at, sizeof row[i]);
      any |= row[i];
    }
    return any != 0;
  }
};

}  // namespace

void RayMarks::begin(const ScanBox& box, const std::vector<geometry::Vec3f>& ends, const geometry::Vec3& origin) {
  box_ = &box;
  origin_ = (origin - box.corner()).cast<float>();
  const std::uint32_t longest = std::max({box.size(0), box.size(1), box.size(2)}) * kSide + 2;
  // Coordinates in fixed point stay below 2^29, so that the largest step can be added to one without overflow.
  for (fraction_bits_ = 0; (std::uint64_t{longest} << (fraction_bits_ + 1)) < (1u << 29);) ++fraction_bits_;
  sort(ends);
}

void RayMarks::sort(const std::vector<geometry::Vec3f>& ends) {
  const geometry::Vec3f corner = box_->corner().cast<float>();
  std::array<std::size_t, kFaces> count{};
  face_of_.resize(ends.size());
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const int face = face_through(ends[i] - corner - origin_);
    face_of_[i] = static_cast<std::uint8_t>(face);
    ++count[static_cast<std::size_t>(face)];
  }
  std::array<std::size_t, kFaces> next{};
  for (std::size_t face = 0, begin = 0; face < kFaces; begin += count[face++]) {
    faces_[face].rays_begin = next[face] = begin;
    faces_[face].rays_end = begin + count[face];
  }
  for (auto& axis : along_) axis.resize(ends.size());
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const std::size_t at = next[face_of_[i]]++;
    const Axes axes = axes_of(face_of_[i]);
    along_[0][at] = ends[i][axes.a] - corner[axes.a];
    along_[1][at] = ends[i][axes.b] - corner[axes.b];
    along_[2][at] = ends[i][axes.c] - corner[axes.c];
  }
  std::iota(by_size_.begin(), by_size_.end(), 0);
  std::stable_sort(by_size_.begin(), by_size_.end(), [&](int a, int b) {
    return count[static_cast<std::size_t>(a)] > count[static_cast<std::size_t>(b)];
  });
}

void RayMarks::cast(int nth) {
  const int which = by_size_[static_cast<std::size_t>(nth)];
  Face& face = faces_[static_cast<std::size_t>(which)];
  face.crossed.clear();
  if (face.rays_begin == face.rays_end) return;
  find_reach(which);
  clear(which);
  const Axes axes = axes_of(which);
  const auto from = [&](int axis) { return along_[static_cast<std::size_t>(axis)].data() + face.rays_begin; };
  kernels::ray_walk::mark_rays({from(0), from(1), from(2), face.rays_end - face.rays_begin, origin_[axes.a],
                                origin_[axes.b], origin_[axes.c], (which & 1) != 0},
                               {face.words.data(), face.zero, face.step_b, face.step_c, fraction_bits_});
  find_crossed(which);
}

void RayMarks::find_reach(int which) {
  Face& face = faces_[static_cast<std::size_t>(which)];
  const Axes axes = axes_of(which);
  const int axis_of[3] = {axes.a, axes.b, axes.c};
  for (std::size_t k = 0; k < 3; ++k) {
    const float* at = along_[k].data();
    const kernels::Extent extent =
        kernels::extent_of(at + face.rays_begin, face.rays_end - face.rays_begin, origin_[axis_of[k]]);
    face.reach[k] = {static_cast<std::int32_t>(extent.low) / kSide, static_cast<std::int32_t>(extent.high) / kSide + 1};
  }
}

void RayMarks::clear(int which) {
  Face& face = faces_[static_cast<std::size_t>(which)];
  const auto& [a, b, c] = face.reach;
  const auto lines = [](const Reach& reach) { return (reach.high - reach.low) * kSide + 2; };
  const std::int32_t first_word = a.low * kSide / kWord;
  face.step_b = (a.high * kSide - 1) / kWord + 1 - first_word;
  face.step_c = face.step_b * lines(b);
  // The image has one spare line before the first that rays reach.
  face.zero = (1 - b.low * kSide) * face.step_b + (1 - c.low * kSide) * face.step_c - first_word;
  face.words.assign(static_cast<std::size_t>(face.step_c) * static_cast<std::size_t>(lines(c)), 0);
}

void RayMarks::find_crossed(int which) {
  Face& face = faces_[static_cast<std::size_t>(which)];
  const auto& [a, b, c] = face.reach;
  const Axes axes = axes_of(which);
  face.crossed.assign(box_->num_blocks(), 0);
  const auto words = static_cast<std::size_t>(face.step_b);
  std::vector<std::uint32_t> all(kSide * words);
  const std::int32_t first_word = a.low * kSide / kWord;
  for (std::int32_t block_c = c.low; block_c < c.high; ++block_c) {
    for (std::int32_t block_b = b.low; block_b < b.high; ++block_b) {
      const std::uint32_t* first =
          face.words.data() + (face.zero + first_word + block_b * kSide * face.step_b + block_c * kSide * face.step_c);
      kernels::unite_rows(first, all.size(), face.step_c, all.data());
      for (std::int32_t block_a = a.low; block_a < a.high; ++block_a) {
        std::uint32_t any = 0;
        const std::int32_t column = block_a * kSide / kWord - first_word;
        const auto word = static_cast<std::size_t>(column);
        for (std::size_t line = 0; line < kSide; ++line) any |= all[line * words + word];
        if (((any >> (block_a * kSide % kWord)) & 0xFFFFu) == 0) continue;
        const auto along = [&](int axis, std::int32_t block) {
          return static_cast<std::uint32_t>(block) * box_->block_stride(axis);
        };
        face.crossed[along(axes.a, block_a) + along(axes.b, block_b) + along(axes.c, block_c)] = 1;
      }
    }
  }
}

bool RayMarks::is_crossed(std::uint32_t block) const {
  return std::any_of(faces_.begin(), faces_.end(),
                     [block](const Face& face) { return !face.crossed.empty() && face.crossed[block] != 0; });
}

const std::uint8_t* RayMarks::line_of(int which, int a, int b, int c) const {
  const Face& face = faces_[static_cast<std::size_t>(which)];
  const std::uint32_t* word = face.words.data() + (face.zero + b * face.step_b + c * face.step_c + a / kWord);
  return reinterpret_cast<const std::uint8_t*>(word) + a % kWord / 8;
}

void RayMarks::add_to(std::uint32_t block, VoxelBits* bits) const {
  const geometry::Index3 first = box_->first_in_box(block);
  const int at[3] = {first.x, first.y, first.z};
  for (int which = 0; which < kFaces; ++which) {
    const Face& face = faces_[static_cast<std::size_t>(which)];
    if (face.crossed.empty() || face.crossed[block] == 0) continue;
    const Axes axes = axes_of(which);
    Rows rows;
    std::uint16_t turned[kSide];
    for (int c = 0; c < kSide; ++c) {
      if (!rows.load(line_of(which, at[axes.a], at[axes.b], at[axes.c] + c),
                     static_cast<std::ptrdiff_t>(face.step_b) * 4))
        continue;
      if (axes.a != 0) kernels::transpose_16(rows.row, turned);
      // Here rows lie along x: one for each b when the face looks along x, else one for each a.
      for (int i = 0; i < kSide; ++i) {
        const int y = axes.a == 2 ? c : i, z = axes.a == 2 ? i : c;
        const std::uint16_t row = axes.a == 0 ? rows.row[i] : turned[i];
        const int word = 4 * z + y / 4;
        (*bits)[static_cast<std::size_t>(word)] |= std::uint64_t{row} << (16 * (y & 3));
      }
    }
  }
}

std::size_t RayMarks::memory_bytes() const {
  std::size_t bytes = face_of_.capacity();
  for (const auto& axis : along_) bytes += axis.capacity() * sizeof(float);
  for (const Face& face : faces_) bytes += face.words.capacity() * sizeof(face.words[0]) + face.crossed.capacity();
  return bytes;
}

}  // namespace voxnav::occupancy
