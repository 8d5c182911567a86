// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

/// The inner loop of the map update: 64 voxels of one byte under a mask of 64 bits. SSE2 is part of every
/// x86-64 processor; other machines take the plain loop, with the same result.
namespace voxnav::occupancy {

/// cells[i] = max(0, cells[i] - amount) for every bit i set in mask.
inline void subtract_where_plain(std::uint8_t* cells, std::uint64_t mask, std::uint8_t amount) {
  for (int i = 0; i < 64; ++i) {
    const std::uint8_t step = (mask >> i) & 1u ? amount : 0;
    cells[i] = static_cast<std::uint8_t>(cells[i] > step ? cells[i] - step : 0);
  }
}

inline void subtract_where(std::uint8_t* cells, std::uint64_t mask, std::uint8_t amount) {
#if defined(__SSE2__)
  const __m128i bit_of_byte = _mm_set1_epi64x(static_cast<long long>(0x8040201008040201ull));
  const __m128i step = _mm_set1_epi8(static_cast<char>(amount));
  for (int i = 0; i < 64; i += 16) {
    const auto part = static_cast<unsigned>((mask >> i) & 0xFFFFu);
    if (part == 0) continue;
    const __m128i spread = _mm_unpacklo_epi64(_mm_set1_epi8(static_cast<char>(part & 0xFFu)),
                                              _mm_set1_epi8(static_cast<char>(part >> 8)));
    const __m128i selected = _mm_cmpeq_epi8(_mm_and_si128(spread, bit_of_byte), bit_of_byte);
    auto* at = reinterpret_cast<__m128i*>(cells + i);
    _mm_storeu_si128(at, _mm_subs_epu8(_mm_loadu_si128(at), _mm_and_si128(selected, step)));
  }
#else
  subtract_where_plain(cells, mask, amount);
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
