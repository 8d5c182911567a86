// SPDX-License-Identifier: BSD-3-Clause
#include "kernels/ray_walk.hpp"

#include <algorithm>

#include "kernels/lanes.hpp"

// Eight rays are walked at once. No branch depends on a single ray, because a processor cannot predict where that ray
// changes voxel next. ray_walk_reference.cpp computes the same ray by ray.

namespace voxnav::kernels::ray_walk {
namespace {

using namespace lanes;  // NOLINT: the vector types of this file

constexpr std::int32_t kNever = 1 << 30;  // fixed-point position behind the ends of all rays
constexpr std::int32_t kInWord = (1 << kWordShift) - 1;

/// Rays from the end with the smaller coordinate on a to the other one.
struct Ends {
  Floats from_a, from_b, from_c, to_a, to_b, to_c;
};

/// The progress on one of the two shorter axes: the fixed-point position on the longest axis at which the ray next
/// changes voxel on this axis, the distance between such changes, and the step to another line at each of them.
struct ShortAxis {
  Ints next, per_cell, step;
};

VOXNAV_INLINE ShortAxis short_axis(Floats from, Floats to, Floats from_a, Floats length_a, std::int32_t step,
                                   float one) {
  const Ints cell = truncated(from);
  const Ints is_up = to >= from;
  const Ints stays = truncated(to) == cell;
  const float most = static_cast<float>(kNever) / one;
  const Floats way = absolute(to - from);
  const Floats per_cell = smaller(length_a / (way > 0.0f ? way : way + 1.0f), Floats{} + most);
  const Floats first = is_up ? floats(cell + 1) - from : from - floats(cell);
  const Ints next = truncated(smaller(from_a + first * per_cell, Floats{} + most) * one);
  const Ints steps = Ints{} + step;
  return {stays ? Ints{} + kNever : next, truncated(per_cell * one + 0.5f), is_up ? steps : -steps};
}

/// Returns the number of runs of a ray. A run is a series of voxels in one word of one line: it ends where the voxel
/// changes on b or c, or where the word ends.
VOXNAV_INLINE Ints num_runs(const Ends& ray) {
  const auto changes = [](Floats from, Floats to, int shift) {
    const Ints n = (truncated(to) >> shift) - (truncated(from) >> shift);
    return larger(n, -n);
  };
  return 1 + changes(ray.from_b, ray.to_b, 0) + changes(ray.from_c, ray.to_c, 0) +
         changes(ray.from_a, ray.to_a, kWordShift);
}

VOXNAV_INLINE void mark(std::uint32_t* words, Ints at, Words bits) {
  // Lanes are read through memory, since extracting them from vectors one by one takes longer.
  alignas(32) std::int32_t to[kLanes];
  alignas(32) std::uint32_t what[kLanes];
  store(at, to);
  store(bits, what);
  VOXNAV_IN_MEMORY(to);
  VOXNAV_IN_MEMORY(what);
  for (int i = 0; i < kLanes; ++i) words[to[i]] |= what[i];
}

VOXNAV_INLINE void walk(const Canvas& canvas, const Ends& ray) {
  const auto one = static_cast<float>(1 << canvas.fraction_bits);
  const Floats length_a = ray.to_a - ray.from_a;
  ShortAxis b = short_axis(ray.from_b, ray.to_b, ray.from_a, length_a, canvas.step_b, one);
  ShortAxis c = short_axis(ray.from_c, ray.to_c, ray.from_a, length_a, canvas.step_c, one);
  Ints line = canvas.zero + truncated(ray.from_b) * canvas.step_b + truncated(ray.from_c) * canvas.step_c;
  Ints at = truncated(ray.from_a);
  const Ints last = truncated(ray.to_a);
  const Ints last_change = truncated(ray.to_a * one);
  for (int left = highest(num_runs(ray)); left > 0; --left) {
    const Ints is_b = b.next <= c.next;
    const Ints next = is_b ? b.next : c.next;
    const Ints changes = next < last_change;
    const Ints target = larger(changes ? next >> canvas.fraction_bits : last, at);
    // A run ends where its word ends; the next run continues in the next word.
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
  // Rounding may have put the last change behind the end of a ray; its last voxel is marked all the same.
  line = canvas.zero + truncated(ray.to_b) * canvas.step_b + truncated(ray.to_c) * canvas.step_c;
  mark(canvas.words, line + (last >> kWordShift), (Words{} + 1u) << (Words)(last & kInWord));
}

VOXNAV_INLINE Floats eight_of(const float* from, std::size_t left) {
  if (left >= kLanes) return loaded<Floats>(from);
  Floats out;  // lanes that would be empty repeat the last ray
  for (std::size_t k = 0; k < kLanes; ++k) out[k] = from[std::min(k, left - 1)];
  return out;
}

VOXNAV_INLINE void walk_all(const Rays& rays, const Canvas& canvas) {
  const Floats zero{}, oa = zero + rays.origin_a, ob = zero + rays.origin_b, oc = zero + rays.origin_c;
  for (std::size_t i = 0; i < rays.size; i += kLanes) {
    const std::size_t left = rays.size - i;
    const Floats a = eight_of(rays.a + i, left), b = eight_of(rays.b + i, left), c = eight_of(rays.c + i, left);
    walk(canvas, rays.is_ascending ? Ends{oa, ob, oc, a, b, c} : Ends{a, b, c, oa, ob, oc});
  }
}
VOXNAV_WIDE void walk_all_wide(const Rays& rays, const Canvas& canvas) { walk_all(rays, canvas); }
void walk_all_plain(const Rays& rays, const Canvas& canvas) { walk_all(rays, canvas); }

}  // namespace

void mark_rays(const Rays& rays, const Canvas& canvas) { (is_wide() ? walk_all_wide : walk_all_plain)(rays, canvas); }

}  // namespace voxnav::kernels::ray_walk
