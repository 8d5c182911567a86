// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "kernels/processor.hpp"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

/// Eight numbers at once, in the vector types of GCC and Clang, which every processor has some instructions for. A
/// comparison gives a lane of all ones where it holds and of all zeros where it does not.
namespace voxnav::kernels::lanes {

constexpr int kLanes = 8;
using Floats = float __attribute__((vector_size(32)));
using Ints = std::int32_t __attribute__((vector_size(32)));
using Words = std::uint32_t __attribute__((vector_size(32)));

VOXNAV_INLINE Floats absolute(Floats x) { return x < 0.0f ? -x : x; }
VOXNAV_INLINE Floats smaller(Floats a, Floats b) { return a < b ? a : b; }
VOXNAV_INLINE Floats larger(Floats a, Floats b) { return a > b ? a : b; }
VOXNAV_INLINE Ints larger(Ints a, Ints b) { return a > b ? a : b; }
VOXNAV_INLINE Ints truncated(Floats x) { return __builtin_convertvector(x, Ints); }
VOXNAV_INLINE Floats floats(Ints x) { return __builtin_convertvector(x, Floats); }
VOXNAV_INLINE std::int32_t highest(Ints x) {
  std::int32_t out = x[0];
  for (int i = 1; i < kLanes; ++i) out = x[i] > out ? x[i] : out;
  return out;
}

/// Lane i of the result is lane order[i] of x, 0 to 7.
VOXNAV_INLINE Ints shuffled(Ints x, Ints order) {
#if defined(__clang__)
  // Clang only shuffles by orders that are known when it compiles.
  Ints out;
  for (int i = 0; i < kLanes; ++i) out[i] = x[order[i] & (kLanes - 1)];
  return out;
#else
  return __builtin_shuffle(x, order);
#endif
}

/// Square roots, rounded as std::sqrt rounds them.
VOXNAV_INLINE Floats exact_root(Floats x) {
#if defined(__SSE2__)
  __m128 halves[2];
  std::memcpy(halves, &x, sizeof x);
  // The result is put together out of four doubles, since two stores of halves are slow to load as a whole.
  using Doubles = double __attribute__((vector_size(32)));
  const __m128d low = _mm_castps_pd(_mm_sqrt_ps(halves[0])), high = _mm_castps_pd(_mm_sqrt_ps(halves[1]));
  const Doubles whole = {low[0], low[1], high[0], high[1]};
  std::memcpy(&x, &whole, sizeof x);
#else
  for (int i = 0; i < kLanes; ++i) x[i] = std::sqrt(x[i]);
#endif
  return x;
}

template <class V, class Number>
VOXNAV_INLINE V loaded(const Number* from) {
  V out;
  std::memcpy(&out, from, sizeof out);
  return out;
}
template <class V, class Number>
VOXNAV_INLINE void store(V x, Number* to) {
  std::memcpy(to, &x, sizeof x);
}

}  // namespace voxnav::kernels::lanes
