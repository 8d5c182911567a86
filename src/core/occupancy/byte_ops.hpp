// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "base/processor.hpp"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

/// The inner loop of the map update: 64 voxels of one byte under a mask of 64 bits. SSE2 is part of every
/// x86-64 processor, AVX2 of most (see processor.hpp); other machines take the plain loop, with the same result.
namespace voxnav::occupancy {

/// Number of set bits. The compiler's own builtin is a call where the popcnt instruction may not be used; where it may,
/// the compiler knows this for what it is.
VOXNAV_INLINE unsigned count_bits(std::uint64_t word) {
  word -= (word >> 1) & 0x5555555555555555u;
  word = (word & 0x3333333333333333u) + ((word >> 2) & 0x3333333333333333u);
  word = (word + (word >> 4)) & 0x0F0F0F0F0F0F0F0Fu;
  return static_cast<unsigned>((word * 0x0101010101010101u) >> 56);
}

/// What a subtraction did to 64 voxels.
struct Subtracted {
  bool any_changed = false;
  unsigned crossed_free = 0;      ///< voxels that came below `free_end`
  unsigned crossed_occupied = 0;  ///< voxels that came below `occupied_min`
};

struct Subtraction {
  std::uint8_t amount;
  std::uint8_t free_end;
  std::uint8_t occupied_min;
};

/// cells[i] = max(0, cells[i] - amount) for every bit i set in mask.
inline Subtracted subtract_where_plain(std::uint8_t* cells, std::uint64_t mask, const Subtraction& by) {
  Subtracted out;
  for (int i = 0; i < 64; ++i) {
    if (((mask >> i) & 1u) == 0) continue;
    const std::uint8_t before = cells[i];
    const auto after = static_cast<std::uint8_t>(before > by.amount ? before - by.amount : 0);
    cells[i] = after;
    out.any_changed = out.any_changed || before != after;
    out.crossed_free += before >= by.free_end && after < by.free_end ? 1 : 0;
    out.crossed_occupied += before >= by.occupied_min && after < by.occupied_min ? 1 : 0;
  }
  return out;
}

#if defined(__SSE2__)
/// Bit i: byte i of a is at least b.
VOXNAV_INLINE unsigned at_least(__m128i a, __m128i b) {
  return static_cast<unsigned>(_mm_movemask_epi8(_mm_cmpeq_epi8(_mm_max_epu8(a, b), a)));
}

/// 0xFF in byte i where bit i is set.
VOXNAV_INLINE __m128i bytes_of_bits(unsigned bits) {
  const __m128i bit_of_byte = _mm_set1_epi64x(static_cast<long long>(0x8040201008040201ull));
  const __m128i spread =
      _mm_unpacklo_epi64(_mm_set1_epi8(static_cast<char>(bits & 0xFFu)), _mm_set1_epi8(static_cast<char>(bits >> 8)));
  return _mm_cmpeq_epi8(_mm_and_si128(spread, bit_of_byte), bit_of_byte);
}
#endif

VOXNAV_INLINE Subtracted subtract_where(std::uint8_t* cells, std::uint64_t mask, const Subtraction& by) {
#if defined(__SSE2__)
  const __m128i step = _mm_set1_epi8(static_cast<char>(by.amount));
  const __m128i free_limit = _mm_set1_epi8(static_cast<char>(by.free_end));
  const __m128i occupied_limit = _mm_set1_epi8(static_cast<char>(by.occupied_min));
  Subtracted out;
  for (int i = 0; i < 64; i += 16) {
    const auto part = static_cast<unsigned>((mask >> i) & 0xFFFFu);
    if (part == 0) continue;
    const __m128i selected = bytes_of_bits(part);
    auto* at = reinterpret_cast<__m128i*>(cells + i);
    const __m128i before = _mm_loadu_si128(at);
    const __m128i after = _mm_subs_epu8(before, _mm_and_si128(selected, step));
    if (_mm_movemask_epi8(_mm_cmpeq_epi8(before, after)) == 0xFFFF) continue;  // all clamped: nothing to do
    _mm_storeu_si128(at, after);
    out.any_changed = true;
    out.crossed_free += count_bits(at_least(before, free_limit) & ~at_least(after, free_limit));
    out.crossed_occupied += count_bits(at_least(before, occupied_limit) & ~at_least(after, occupied_limit));
  }
  return out;
#else
  return subtract_where_plain(cells, mask, by);
#endif
}

/// For callers that are marked VOXNAV_WIDE themselves.
#if defined(__SSE2__)
/// Bit i: byte i of a is less than b.
VOXNAV_WIDE VOXNAV_INLINE unsigned below(__m256i a, __m256i b) {
  return ~static_cast<unsigned>(_mm256_movemask_epi8(_mm256_cmpeq_epi8(_mm256_max_epu8(a, b), a)));
}

VOXNAV_WIDE inline Subtracted subtract_where_wide(std::uint8_t* cells, std::uint64_t mask, const Subtraction& by) {
  const __m256i step = _mm256_set1_epi8(static_cast<char>(by.amount));
  const __m256i free_limit = _mm256_set1_epi8(static_cast<char>(by.free_end));
  const __m256i occupied_limit = _mm256_set1_epi8(static_cast<char>(by.occupied_min));
  const __m256i byte_of_mask = _mm256_setr_epi64x(0, 0x0101010101010101, 0x0202020202020202, 0x0303030303030303);
  const __m256i bit_of_byte = _mm256_set1_epi64x(static_cast<long long>(0x8040201008040201ull));
  Subtracted out;
  for (int i = 0; i < 64; i += 32) {
    const auto part = static_cast<int>(mask >> i);
    if (part == 0) continue;
    const __m256i spread = _mm256_shuffle_epi8(_mm256_set1_epi32(part), byte_of_mask);
    const __m256i selected = _mm256_cmpeq_epi8(_mm256_and_si256(spread, bit_of_byte), bit_of_byte);
    auto* at = reinterpret_cast<__m256i*>(cells + i);
    const __m256i before = _mm256_loadu_si256(at);
    const __m256i after = _mm256_subs_epu8(before, _mm256_and_si256(selected, step));
    if (_mm256_movemask_epi8(_mm256_cmpeq_epi8(before, after)) == -1) continue;  // all clamped: nothing to do
    _mm256_storeu_si256(at, after);
    out.any_changed = true;
    out.crossed_free += count_bits(below(after, free_limit) & ~below(before, free_limit));
    out.crossed_occupied += count_bits(below(after, occupied_limit) & ~below(before, occupied_limit));
  }
  return out;
}
#else
inline Subtracted subtract_where_wide(std::uint8_t* cells, std::uint64_t mask, const Subtraction& by) {
  return subtract_where_plain(cells, mask, by);
}
#endif

/// Bit i: cells[i] of 64 is at least `limit`, which may be more than any cell can be.
inline std::uint64_t bits_at_least(const std::uint8_t* cells, int limit) {
  if (limit > 255) return 0;
  std::uint64_t out = 0;
#if defined(__SSE2__)
  const __m128i limits = _mm_set1_epi8(static_cast<char>(limit));
  for (int i = 0; i < 64; i += 16) {
    out |= std::uint64_t{at_least(_mm_loadu_si128(reinterpret_cast<const __m128i*>(cells + i)), limits)} << i;
  }
#else
  for (int i = 0; i < 64; ++i) out |= static_cast<std::uint64_t>(cells[i] >= limit ? 1 : 0) << i;
#endif
  return out;
}

/// Turns 16 rows of 16 bits into columns: bit i of out[k] is bit k of rows[i].
VOXNAV_INLINE void transpose_16(const std::uint16_t* rows, std::uint16_t* out) {
#if defined(__SSE2__)
  const __m128i first = _mm_loadu_si128(reinterpret_cast<const __m128i*>(rows));
  const __m128i second = _mm_loadu_si128(reinterpret_cast<const __m128i*>(rows + 8));
  const __m128i low_byte = _mm_set1_epi16(0xFF);
  __m128i low = _mm_packus_epi16(_mm_and_si128(first, low_byte), _mm_and_si128(second, low_byte));
  __m128i high = _mm_packus_epi16(_mm_srli_epi16(first, 8), _mm_srli_epi16(second, 8));
  for (int k = 7; k >= 0; --k) {
    out[k] = static_cast<std::uint16_t>(_mm_movemask_epi8(low));
    out[k + 8] = static_cast<std::uint16_t>(_mm_movemask_epi8(high));
    low = _mm_add_epi8(low, low);
    high = _mm_add_epi8(high, high);
  }
#else
  for (int k = 0; k < 16; ++k) {
    unsigned column = 0;
    for (int i = 0; i < 16; ++i) column |= ((rows[i] >> k) & 1u) << i;
    out[k] = static_cast<std::uint16_t>(column);
  }
#endif
}

/// Calls f(index) for every set bit, lowest first.
template <class F>
VOXNAV_INLINE void for_each_bit(std::uint64_t word, F&& f) {
  while (word != 0) {
    f(__builtin_ctzll(word));
    word &= word - 1;
  }
}

}  // namespace voxnav::occupancy
