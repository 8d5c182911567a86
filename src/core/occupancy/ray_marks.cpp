// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/ray_marks.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace voxnav::occupancy {
namespace {

/// Positions are fixed-point numbers: exact sums, and the voxel is a shift away. ScanBox::kMaxSide voxels fit.
constexpr int kFractionBits = 20;
constexpr double kOne = 1 << kFractionBits;

/// Four slabs at once; the compiler makes vector instructions of these on every machine that has some.
using Int4 = std::int32_t __attribute__((vector_size(16)));
using Short8 = std::int16_t __attribute__((vector_size(16)));
using Float4 = float __attribute__((vector_size(16)));

std::int32_t fixed(double value) { return static_cast<std::int32_t>(value * kOne); }
Int4 all(std::int32_t value) { return Int4{value, value, value, value}; }
Int4 choose(Int4 mask, Int4 a, Int4 b) { return (mask & a) | (~mask & b); }
/// The vector that begins with the last of `before`.
Int4 shifted_in(Int4 before, Int4 now) { return __builtin_shuffle(before, now, Int4{3, 4, 5, 6}); }

/// A plain store that other threads may make at the same time.
inline void store(std::uint8_t* at, std::uint8_t value) { __atomic_store_n(at, value, __ATOMIC_RELAXED); }

/// Part of an address that a position contributes on one axis.
class AddressPart {
 public:
  AddressPart(std::uint32_t block_stride, int axis)
      : stride_(all(static_cast<std::int32_t>(block_stride))),
        inside_shift_(kFractionBits - geometry::kBlockShift * axis),
        inside_mask_(all((geometry::kBlockSide - 1) << (geometry::kBlockShift * axis))) {}
  Int4 of(Int4 position) const {
    // Block numbers have 16 bits (ScanBox::kMaxBlocks), for which there is a multiplication everywhere.
    const Int4 block = position >> (kFractionBits + geometry::kBlockShift);
    const auto product = reinterpret_cast<Int4>(reinterpret_cast<Short8>(block) * reinterpret_cast<Short8>(stride_));
    return (product << (3 * geometry::kBlockShift)) | ((position >> inside_shift_) & inside_mask_);
  }

 private:
  Int4 stride_;
  int inside_shift_;
  Int4 inside_mask_;
};

/// Goes along one of the short axes of a ray from border to border of the longest one, never beyond its end.
class ShortAxis {
 public:
  ShortAxis(double from, double to, double slope, double to_border, const AddressPart& part)
      : part_(part), limit_(all(fixed(to))), is_down_(slope < 0.0 ? all(-1) : all(0)) {
    const std::int32_t step = fixed(slope), first = fixed(from + to_border * slope);
    border_ = Int4{first, first + step, first + 2 * step, first + 3 * step};
    step_ = all(4 * step);
    speed_ = std::abs(static_cast<float>(slope)) * Float4{1.0f, 1.0f, 1.0f, 1.0f};
    exit_ = all(fixed(from));
    exit_part_ = part_.of(exit_);
  }
  /// The next four slabs.
  void advance() {
    const Int4 reached = choose((border_ > limit_) ^ is_down_, limit_, border_);
    entry_ = shifted_in(exit_, reached);
    exit_ = reached;
    const Int4 part = part_.of(reached);
    entry_part_ = shifted_in(exit_part_, part);
    exit_part_ = part;
    border_ += step_;
  }
  Int4 entry_part() const { return entry_part_; }
  Int4 exit_part() const { return exit_part_; }
  Float4 speed() const { return speed_; }
  /// From the entry to the next border of a voxel.
  Float4 way() const {
    const Int4 fraction = (entry_ ^ ~is_down_) & all((1 << kFractionBits) - 1);
    return __builtin_convertvector(fraction, Float4);
  }

 private:
  AddressPart part_;
  Int4 limit_, is_down_, border_, step_;
  Float4 speed_;
  Int4 entry_{}, exit_, entry_part_{}, exit_part_;
};

}  // namespace

void RayMarks::begin(const ScanBox& box) {
  box_ = &box;
  rows_.resize(std::max<std::size_t>(rows_.size(), std::size_t{64} * box.num_blocks()));
  voxels_.resize(64 * rows_.size());
}

bool RayMarks::is_block_crossed(std::uint32_t block) const {
  std::uint64_t words[8];
  std::memcpy(words, rows_.data() + 64 * std::size_t{block}, sizeof(words));
  std::uint64_t any = 0;
  for (const std::uint64_t word : words) any |= word;
  return any != 0;
}

void RayMarks::clear(std::uint32_t block) {
  std::uint8_t* rows = rows_.data() + 64 * std::size_t{block};
  for (int row = 0; row < 64; ++row) {
    if (rows[row] != 0) std::memset(voxels_.data() + 64 * (64 * std::size_t{block} + row), 0, 64);
  }
  std::memset(rows, 0, 64);
}

template <class Addresses>
inline void RayMarks::mark(const Addresses& addresses) {
  for (int i = 0; i < 4; ++i) {
    const auto address = static_cast<std::uint32_t>(addresses[i]);
    store(voxels_.data() + address, kCrossed);
    store(rows_.data() + (address >> 6), 1);
  }
}

/// Nothing in the loop depends on what the ray meets, so no branch is ever mispredicted: in each slab the voxels at
/// its entry and its exit are marked, and the one between, which is one of these unless both short axes change. That
/// one lies behind the border that comes first: the one reached at the smaller share of the slab.
void RayMarks::cast(const geometry::Vec3f& end, const geometry::Vec3& origin) {
  const geometry::Vec3 corner = box_->corner();
  const geometry::Vec3 from = end.cast<double>() - corner;
  const geometry::Vec3 to = origin - corner;
  const geometry::Vec3 delta = to - from;
  int a = 0;
  const double length = delta.cwiseAbs().maxCoeff(&a);
  const int b_axis = (a + 1) % 3, c_axis = (a + 2) % 3;
  const double scale = length > 0.0 ? 1.0 / length : 0.0;
  const auto first = static_cast<std::int32_t>(from[a]), last = static_cast<std::int32_t>(to[a]);
  const bool is_down = delta[a] < 0.0;
  const double to_border = is_down ? from[a] - first : first + 1 - from[a];
  const auto part = [&](int axis) { return AddressPart(box_->block_stride(axis), axis); };
  ShortAxis b(from[b_axis], to[b_axis], delta[b_axis] * scale, to_border, part(b_axis));
  ShortAxis c(from[c_axis], to[c_axis], delta[c_axis] * scale, to_border, part(c_axis));
  const AddressPart a_part = part(a);
  const std::int32_t step = (is_down ? -1 : 1) * (1 << kFractionBits);
  Int4 along = all(first * (1 << kFractionBits)) + Int4{0, step, 2 * step, 3 * step};
  const Int4 limit = all(last * (1 << kFractionBits)), down = all(is_down ? -1 : 0);
  for (int slab = std::abs(last - first); slab >= 0; slab -= 4) {
    b.advance();
    c.advance();
    const Int4 slabs = a_part.of(choose((along > limit) ^ down, limit, along));
    const Int4 is_b_first = b.way() * c.speed() < c.way() * b.speed();
    const Int4 between = choose(is_b_first, b.exit_part() + c.entry_part(), b.entry_part() + c.exit_part());
    mark(slabs + b.entry_part() + c.entry_part());
    mark(slabs + between);
    mark(slabs + b.exit_part() + c.exit_part());
    along += all(4 * step);
  }
}

}  // namespace voxnav::occupancy
