// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/ray_marks.hpp"

#include <algorithm>
#include <cstring>

#include "ray_walk.hpp"
#include "voxnav/occupancy/byte_ops.hpp"

namespace voxnav::occupancy {
namespace {

using namespace ray_walk;  // NOLINT: the vector types of this file

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "words of a line are read as rows of 16 voxels");

constexpr int kSide = geometry::kBlockSide;
constexpr int kWordShift = 5;
constexpr std::int32_t kInWord = 31;

struct Canvas {
  std::uint32_t* words;
  std::array<RayMarks::Image, 3> images;
  int fraction_bits;
};

VOXNAV_INLINE void mark(std::uint32_t* words, Ints at, Words bits) {
  // Through memory: taking lanes out of vectors one by one takes longer.
  alignas(32) std::int32_t to[kLanes];
  alignas(32) std::uint32_t what[kLanes];
  store(at, to);
  store(bits, what);
  VOXNAV_IN_MEMORY(to);
  VOXNAV_IN_MEMORY(what);
  for (int i = 0; i < kLanes; ++i) words[to[i]] |= what[i];
}

VOXNAV_INLINE Ends ordered(const Choice& longest, Floats x, Floats y, Floats z, const geometry::Vec3f& origin) {
  const Floats zero{};
  const Floats a = longest.of(x, y, z), b = longest.of(y, x, x), c = longest.of(z, z, y);
  const Floats ox = zero + origin.x(), oy = zero + origin.y(), oz = zero + origin.z();
  const Floats oa = longest.of(ox, oy, oz), ob = longest.of(oy, ox, ox), oc = longest.of(oz, oz, oy);
  const Ints is_back = a > oa;
  return {is_back ? oa : a, is_back ? ob : b, is_back ? oc : c, is_back ? a : oa, is_back ? b : ob, is_back ? c : oc};
}

/// How many words a ray marks.
VOXNAV_INLINE Ints num_runs(const Ends& ray) {
  const auto changes = [](Floats from, Floats to, int shift) {
    const Ints n = (truncated(to) >> shift) - (truncated(from) >> shift);
    return larger(n, -n);
  };
  return 1 + changes(ray.from_b, ray.to_b, 0) + changes(ray.from_c, ray.to_c, 0) +
         changes(ray.from_a, ray.to_a, kWordShift);
}

VOXNAV_INLINE void walk(const Canvas& canvas, Floats x, Floats y, Floats z, const geometry::Vec3f& origin) {
  const Floats wx = absolute(x - origin.x()), wy = absolute(y - origin.y()), wz = absolute(z - origin.z());
  const Ints is_x = (wx >= wy) & (wx >= wz);
  const Choice longest{is_x, ~is_x & (wy >= wz)};
  const Ends ray = ordered(longest, x, y, z, origin);
  const auto constant = [&](std::int32_t RayMarks::Image::*field) {
    const Ints zero{};
    return longest.of(zero + canvas.images[0].*field, zero + canvas.images[1].*field, zero + canvas.images[2].*field);
  };
  const Ints step_b = constant(&RayMarks::Image::step_b), step_c = constant(&RayMarks::Image::step_c);
  const Ints zero_line = constant(&RayMarks::Image::zero);
  const auto one = static_cast<float>(1 << canvas.fraction_bits);
  const Floats length_a = ray.to_a - ray.from_a;
  ShortAxis b = short_axis(ray.from_b, ray.to_b, ray.from_a, length_a, step_b, one);
  ShortAxis c = short_axis(ray.from_c, ray.to_c, ray.from_a, length_a, step_c, one);
  Ints line = zero_line + truncated(ray.from_b) * step_b + truncated(ray.from_c) * step_c;
  Ints at = truncated(ray.from_a);
  const Ints last = truncated(ray.to_a);
  const Ints last_change = truncated(ray.to_a * one);
  for (int left = highest(num_runs(ray)); left > 0; --left) {
    const Ints is_b = b.next <= c.next;
    const Ints next = is_b ? b.next : c.next;
    const Ints changes = next < last_change;
    const Ints target = larger(changes ? next >> canvas.fraction_bits : last, at);
    // A run ends where its word ends; it goes on in the next one.
    const Ints word_end = at | kInWord;
    const Ints is_cut = target > word_end;
    const Ints stop = is_cut ? word_end : target;
    const Words low = (Words{} + 1u) << (Words)(at & kInWord), high = (Words{} + 2u) << (Words)(stop & kInWord);
    mark(canvas.words, line + (at >> kWordShift), high - low);
    const Ints takes = changes & ~is_cut;
    b.next += b.per_cell & takes & is_b;
    c.next += c.per_cell & takes & ~is_b;
    line += (b.step & takes & is_b) + (c.step & takes & ~is_b);
    at = is_cut ? word_end + 1 : target;
  }
  // Where rounding has put the last change behind the end.
  line = zero_line + truncated(ray.to_b) * step_b + truncated(ray.to_c) * step_c;
  mark(canvas.words, line + (last >> kWordShift), (Words{} + 1u) << (Words)(last & kInWord));
}

VOXNAV_INLINE void walk_all(const Canvas& canvas, const RayEnds& ends, std::size_t first, std::size_t last,
                            const geometry::Vec3f& corner, const geometry::Vec3f& origin) {
  for (std::size_t i = first; i < last; i += kLanes) {
    Floats p[3];
    for (int axis = 0; axis < 3; ++axis) {
      const float* from = ends.along[static_cast<std::size_t>(axis)].data() + i;
      // The last rays are walked again in lanes that would be empty.
      for (std::size_t k = 0; k < kLanes; ++k) p[axis][k] = from[std::min(k, last - i - 1)];
      p[axis] -= corner[axis];
    }
    walk(canvas, p[0], p[1], p[2], origin);
  }
}

VOXNAV_WIDE void walk_all_wide(const Canvas& canvas, const RayEnds& ends, std::size_t first, std::size_t last,
                               const geometry::Vec3f& corner, const geometry::Vec3f& origin) {
  walk_all(canvas, ends, first, last, corner, origin);
}

/// 16 rows of 16 voxels of an image, and whether any is marked.
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

void RayMarks::begin(const ScanBox& box) {
  box_ = &box;
  std::uint32_t longest = 0, size = 0;
  for (int a = 0; a < 3; ++a) {
    const auto lines = [&](int axis) { return box.size(axis) * kSide + 2; };
    Image& image = images_[static_cast<std::size_t>(a)];
    image.step_b = static_cast<std::int32_t>((box.size(a) * kSide + kInWord) >> kWordShift);
    image.step_c = image.step_b * static_cast<std::int32_t>(lines(a == 0 ? 1 : 0));
    image.zero = static_cast<std::int32_t>(size) + image.step_b + image.step_c;
    size += static_cast<std::uint32_t>(image.step_c) * lines(a == 2 ? 1 : 2);
    longest = std::max(longest, lines(a));
  }
  words_.assign(size, 0);
  // Coordinates stay below 2^29, so that the sum of one and kNever is still a number.
  for (fraction_bits_ = 0; (std::uint64_t{longest} << (fraction_bits_ + 1)) < (1u << 29);) ++fraction_bits_;
}

void RayMarks::cast(const RayEnds& ends, std::size_t first, std::size_t last, const geometry::Vec3& origin) {
  const geometry::Vec3f corner = box_->corner().cast<float>();
  const geometry::Vec3f from = origin.cast<float>() - corner;
  const Canvas canvas{words_.data(), images_, fraction_bits_};
  (base::is_wide() ? walk_all_wide : walk_all)(canvas, ends, first, last, corner, from);
}

const std::uint8_t* RayMarks::line_of(int axis, int a, int b, int c) const {
  const Image& image = images_[static_cast<std::size_t>(axis)];
  const std::uint32_t* line = words_.data() + image.zero + b * image.step_b + c * image.step_c;
  return reinterpret_cast<const std::uint8_t*>(line) + a / 8;
}

namespace {

/// What any of 16 times `count` words holds, `step` words apart.
VOXNAV_INLINE void unite(const std::uint32_t* from, std::size_t count, std::ptrdiff_t step, std::uint32_t* all) {
  std::memcpy(all, from, count * sizeof *all);
  for (int i = 1; i < kSide; ++i) {
    const std::uint32_t* next = from + i * step;
    for (std::size_t k = 0; k < count; ++k) all[k] |= next[k];
  }
}
VOXNAV_WIDE void unite_wide(const std::uint32_t* from, std::size_t count, std::ptrdiff_t step, std::uint32_t* all) {
  unite(from, count, step, all);
}

}  // namespace

void RayMarks::finish() {
  crossed_.assign(box_->num_blocks(), 0);
  std::vector<std::uint32_t> all;
  for (int a = 0; a < 3; ++a) {
    const int b = a == 0 ? 1 : 0, c = a == 2 ? 1 : 2;
    const Image& image = images_[static_cast<std::size_t>(a)];
    const auto words = static_cast<std::size_t>(image.step_b);
    all.resize(kSide * words);
    for (std::uint32_t bc = 0; bc < box_->size(b) * box_->size(c); ++bc) {
      const std::uint32_t block_b = bc % box_->size(b), block_c = bc / box_->size(b);
      const std::uint32_t* first = words_.data() + image.zero +
                                   static_cast<std::int32_t>(block_b * kSide) * image.step_b +
                                   static_cast<std::int32_t>(block_c * kSide) * image.step_c;
      (base::is_wide() ? unite_wide : unite)(first, all.size(), image.step_c, all.data());
      for (std::uint32_t block_a = 0; block_a < box_->size(a); ++block_a) {
        std::uint32_t any = 0;
        for (std::size_t line = 0; line < kSide; ++line) any |= all[line * words + block_a / 2];
        if (((any >> (kSide * (block_a & 1u))) & 0xFFFFu) == 0) continue;
        const std::uint32_t block =
            block_a * box_->block_stride(a) + block_b * box_->block_stride(b) + block_c * box_->block_stride(c);
        crossed_[block] |= static_cast<std::uint8_t>(1u << a);
      }
    }
  }
}

void RayMarks::add_to(std::uint32_t block, VoxelBits* bits) const {
  const geometry::Index3 first = box_->first_in_box(block);
  const auto bytes = [&](int a) {
    return static_cast<std::ptrdiff_t>(images_[static_cast<std::size_t>(a)].step_b) * 4;
  };
  const auto set = [&](int y, int z, std::uint16_t row) {
    (*bits)[static_cast<std::size_t>(4 * z + y / 4)] |= std::uint64_t{row} << (16 * (y & 3));
  };
  Rows rows;
  std::uint16_t turned[kSide];
  for (int z = 0; z < kSide && (crossed_[block] & 1u) != 0; ++z) {  // rows in the order of the voxels already
    if (!rows.load(line_of(0, first.x, first.y, first.z + z), bytes(0))) continue;
    for (int y = 0; y < kSide; ++y) set(y, z, rows.row[y]);
  }
  for (int z = 0; z < kSide && (crossed_[block] & 2u) != 0; ++z) {
    if (!rows.load(line_of(1, first.y, first.x, first.z + z), bytes(1))) continue;
    transpose_16(rows.row, turned);
    for (int y = 0; y < kSide; ++y) set(y, z, turned[y]);
  }
  for (int y = 0; y < kSide && (crossed_[block] & 4u) != 0; ++y) {
    if (!rows.load(line_of(2, first.z, first.x, first.y + y), bytes(2))) continue;
    transpose_16(rows.row, turned);
    for (int z = 0; z < kSide; ++z) set(y, z, turned[z]);
  }
}

}  // namespace voxnav::occupancy
