// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

/// The inner loop of the map update: 64 voxels of one byte under a mask of 64 bits. SSE2 is part of every
/// x86-64 processor; other machines take the plain loop, with the same result.
namespace voxnav::occupancy {

/// What a subtraction did to 64 voxels.
struct Subtracted {
  bool any_changed = false;
  std::uint64_t crossed_free = 0;      ///< voxels that came below `free_end`
  std::uint64_t crossed_occupied = 0;  ///< voxels that came below `occupied_min`
};

/// cells[i] = max(0, cells[i] - amount) for every bit i set in mask.
inline Subtracted subtract_where_plain(std::uint8_t* cells, std::uint64_t mask, std::uint8_t amount,
                                       std::uint8_t free_end, std::uint8_t occupied_min) {
  Subtracted out;
  for (int i = 0; i < 64; ++i) {
    if (((mask >> i) & 1u) == 0) continue;
    const std::uint8_t before = cells[i];
    const auto after = static_cast<std::uint8_t>(before > amount ? before - amount : 0);
    cells[i] = after;
    out.any_changed = out.any_changed || before != after;
    if (before >= free_end && after < free_end) out.crossed_free |= std::uint64_t{1} << i;
    if (before >= occupied_min && after < occupied_min) out.crossed_occupied |= std::uint64_t{1} << i;
  }
  return out;
}

#if defined(__SSE2__)
/// Bit i: byte i of a is at least b.
inline unsigned at_least(__m128i a, __m128i b) {
  return static_cast<unsigned>(_mm_movemask_epi8(_mm_cmpeq_epi8(_mm_max_epu8(a, b), a)));
}
#endif

inline Subtracted subtract_where(std::uint8_t* cells, std::uint64_t mask, std::uint8_t amount, std::uint8_t free_end,
                                 std::uint8_t occupied_min) {
#if defined(__SSE2__)
  const __m128i bit_of_byte = _mm_set1_epi64x(static_cast<long long>(0x8040201008040201ull));
  const __m128i step = _mm_set1_epi8(static_cast<char>(amount));
  const __m128i free_limit = _mm_set1_epi8(static_cast<char>(free_end));
  const __m128i occupied_limit = _mm_set1_epi8(static_cast<char>(occupied_min));
  Subtracted out;
  for (int i = 0; i < 64; i += 16) {
    const auto part = static_cast<unsigned>((mask >> i) & 0xFFFFu);
    if (part == 0) continue;
    const __m128i spread =
        _mm_unpacklo_epi64(_mm_set1_epi8(static_cast<char>(part & 0xFFu)), _mm_set1_epi8(static_cast<char>(part >> 8)));
    const __m128i selected = _mm_cmpeq_epi8(_mm_and_si128(spread, bit_of_byte), bit_of_byte);
    auto* at = reinterpret_cast<__m128i*>(cells + i);
    const __m128i before = _mm_loadu_si128(at);
    const __m128i after = _mm_subs_epu8(before, _mm_and_si128(selected, step));
    if (_mm_movemask_epi8(_mm_cmpeq_epi8(before, after)) == 0xFFFF) continue;  // all clamped: nothing to do
    _mm_storeu_si128(at, after);
    out.any_changed = true;
    out.crossed_free |= std::uint64_t{at_least(before, free_limit) & ~at_least(after, free_limit)} << i;
    out.crossed_occupied |= std::uint64_t{at_least(before, occupied_limit) & ~at_least(after, occupied_limit)} << i;
  }
  return out;
#else
  return subtract_where_plain(cells, mask, amount, free_end, occupied_min);
#endif
}

/// Calls f(index) for every set bit, lowest first.
template <class F>
inline void for_each_bit(std::uint64_t word, F&& f) {
  while (word != 0) {
    f(__builtin_ctzll(word));
    word &= word - 1;
  }
}

}  // namespace voxnav::occupancy
