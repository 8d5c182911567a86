// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "kernels/processor.hpp"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace voxnav::kernels {

namespace reference {

inline unsigned count_bits(std::uint64_t word) {
  unsigned out = 0;
  for (int i = 0; i < 64; ++i) out += (word >> i) & 1u;
  return out;
}

inline void transpose_16(const std::uint16_t* rows, std::uint16_t* columns) {
  for (int k = 0; k < 16; ++k) {
    unsigned column = 0;
    for (int i = 0; i < 16; ++i) column |= ((rows[i] >> k) & 1u) << i;
    columns[k] = static_cast<std::uint16_t>(column);
  }
}

}  // namespace reference

/// Returns the number of set bits. The compiler's builtin would be a function call in builds without the popcnt
/// instruction; in builds with it, compilers recognise this code and use the instruction.
VOXNAV_INLINE unsigned count_bits(std::uint64_t word) {
  word -= (word >> 1) & 0x5555555555555555u;
  word = (word & 0x3333333333333333u) + ((word >> 2) & 0x3333333333333333u);
  word = (word + (word >> 4)) & 0x0F0F0F0F0F0F0F0Fu;
  return static_cast<unsigned>((word * 0x0101010101010101u) >> 56);
}

/// Calls f(index) for every set bit, lowest first.
template <class F>
VOXNAV_INLINE void for_each_bit(std::uint64_t word, F&& f) {
  while (word != 0) {
    f(__builtin_ctzll(word));
    word &= word - 1;
  }
}

/// Transposes a matrix of 16 x 16 bits: bit i of columns[k] is bit k of rows[i].
VOXNAV_INLINE void transpose_16(const std::uint16_t* rows, std::uint16_t* columns) {
#if defined(__SSE2__)
  const __m128i first = _mm_loadu_si128(reinterpret_cast<const __m128i*>(rows));
  const __m128i second = _mm_loadu_si128(reinterpret_cast<const __m128i*>(rows + 8));
  const __m128i low_byte = _mm_set1_epi16(0xFF);
  __m128i low = _mm_packus_epi16(_mm_and_si128(first, low_byte), _mm_and_si128(second, low_byte));
  __m128i high = _mm_packus_epi16(_mm_srli_epi16(first, 8), _mm_srli_epi16(second, 8));
  for (int k = 7; k >= 0; --k) {  // the highest bits of the bytes are a column; then the next ones move up
    columns[k] = static_cast<std::uint16_t>(_mm_movemask_epi8(low));
    columns[k + 8] = static_cast<std::uint16_t>(_mm_movemask_epi8(high));
    low = _mm_add_epi8(low, low);
    high = _mm_add_epi8(high, high);
  }
#else
  reference::transpose_16(rows, columns);
#endif
}

}  // namespace voxnav::kernels
