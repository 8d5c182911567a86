// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "kernels/ray_walk.hpp"

namespace voxnav::kernels::ray_walk::reference {
namespace {

constexpr std::int32_t kNever = 1 << 30;
constexpr std::int32_t kWordBits = 1 << kWordShift;

struct CanvasPoint {
  float a, b, c;
};

/// One of the two shorter axes: where on axis a, in fixed point, the ray next changes voxel on this one, how far such
/// changes are apart, and by how much a change moves the line of the canvas.
struct ShortAxis {
  std::int32_t next, per_cell, step;
};

ShortAxis short_axis(float from, float to, float from_a, float length_a, std::int32_t step, int fraction_bits) {
  const auto one = static_cast<float>(1 << fraction_bits);
  const float most = static_cast<float>(kNever) / one;
  const auto cell = static_cast<std::int32_t>(from);
  const float way = std::abs(to - from);
  const float per_cell = std::min(length_a / (way > 0.0f ? way : way + 1.0f), most);
  const bool is_up = to >= from;
  const float first = is_up ? static_cast<float>(cell + 1) - from : from - static_cast<float>(cell);
  const auto next = static_cast<std::int32_t>(std::min(from_a + first * per_cell, most) * one);
  const bool stays = static_cast<std::int32_t>(to) == cell;
  const float rounded = per_cell * one + 0.5f;
  return {stays ? kNever : next, static_cast<std::int32_t>(rounded), is_up ? step : -step};
}

void mark_run(const Canvas& canvas, std::int32_t line, std::int32_t first, std::int32_t last) {
  for (std::int32_t a = first; a <= last; ++a) {
    canvas.words[line + a / kWordBits] |= 1u << (a % kWordBits);
  }
}

int num_runs(const CanvasPoint& from, const CanvasPoint& to) {
  const auto cells = [](float x, float y) { return std::abs(static_cast<int>(y) - static_cast<int>(x)); };
  const int words = static_cast<int>(to.a) / kWordBits - static_cast<int>(from.a) / kWordBits;
  return 1 + cells(from.b, to.b) + cells(from.c, to.c) + std::abs(words);
}

/// @param from, to  ends of one ray, that with the smaller coordinate on axis a first
void mark_ray(const Canvas& canvas, const CanvasPoint& from, const CanvasPoint& to) {
  ShortAxis b = short_axis(from.b, to.b, from.a, to.a - from.a, canvas.step_b, canvas.fraction_bits);
  ShortAxis c = short_axis(from.c, to.c, from.a, to.a - from.a, canvas.step_c, canvas.fraction_bits);
  const auto line_of = [&](const CanvasPoint& p) {
    return canvas.zero + static_cast<std::int32_t>(p.b) * canvas.step_b +
           static_cast<std::int32_t>(p.c) * canvas.step_c;
  };
  std::int32_t line = line_of(from);
  auto at = static_cast<std::int32_t>(from.a);
  const auto last = static_cast<std::int32_t>(to.a);
  const auto last_change = static_cast<std::int32_t>(to.a * static_cast<float>(1 << canvas.fraction_bits));
  for (int left = num_runs(from, to); left > 0; --left) {
    ShortAxis& axis = b.next <= c.next ? b : c;
    const bool changes = axis.next < last_change;
    const std::int32_t target = std::max(changes ? axis.next >> canvas.fraction_bits : last, at);
    const std::int32_t word_end = at | (kWordBits - 1);
    mark_run(canvas, line, at, std::min(target, word_end));
    if (target > word_end) {  // the run goes on in the next word
      at = word_end + 1;
      continue;
    }
    at = target;
    if (!changes) continue;
    line += axis.step;
    axis.next += axis.per_cell;
  }
  mark_run(canvas, line_of(to), last, last);
}

}  // namespace

void mark_rays(const Rays& rays, const Canvas& canvas) {
  const CanvasPoint origin{rays.origin_a, rays.origin_b, rays.origin_c};
  for (std::size_t i = 0; i < rays.size; ++i) {
    const CanvasPoint end{rays.a[i], rays.b[i], rays.c[i]};
    mark_ray(canvas, rays.is_ascending ? origin : end, rays.is_ascending ? end : origin);
  }
}

}  // namespace voxnav::kernels::ray_walk::reference
