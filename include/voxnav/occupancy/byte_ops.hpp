// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

/// The inner loop of the map update: 64 voxels of one byte under a mask of 64 bits. SSE2 is part of every
/// x86-64 processor; other machines take the plain loop, with the same result.
namespace voxnav::occupancy {

/// Number of set bits. The compiler's own builtin is a call where the popcnt instruction may not be used.
inline unsigned count_bits(std::uint64_t word) {
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
inline unsigned at_least(__m128i a, __m128i b) {
  return static_cast<unsigned>(_mm_movemask_epi8(_mm_cmpeq_epi8(_mm_max_epu8(a, b), a)));
}

/// 0xFF in byte i where bit i is set.
inline __m128i bytes_of_bits(unsigned bits) {
  const __m128i bit_of_byte = _mm_set1_epi64x(static_cast<long long>(0x8040201008040201ull));
  const __m128i spread =
      _mm_unpacklo_epi64(_mm_set1_epi8(static_cast<char>(bits & 0xFFu)), _mm_set1_epi8(static_cast<char>(bits >> 8)));
  return _mm_cmpeq_epi8(_mm_and_si128(spread, bit_of_byte), bit_of_byte);
}
#endif

inline Subtracted subtract_where(std::uint8_t* cells, std::uint64_t mask, const Subtraction& by) {
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

/// Turns 16 rows of 16 bits into columns: bit i of out[k] is bit k of in[i * stride]. False when nothing is set; `out`
/// is then left as it was.
inline bool transpose_16(const std::uint16_t* in, int stride, std::uint16_t* out) {
  alignas(16) std::uint16_t rows[16];
  unsigned any = 0;
  for (int i = 0; i < 16; ++i) any |= rows[i] = in[i * stride];
  if (any == 0) return false;
#if defined(__SSE2__)
  const __m128i first = _mm_load_si128(reinterpret_cast<const __m128i*>(rows));
  const __m128i second = _mm_load_si128(reinterpret_cast<const __m128i*>(rows + 8));
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
  return true;
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
