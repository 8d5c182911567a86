// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernels/bits.hpp"
#include "kernels/processor.hpp"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

/// The inner loop of the map update: 64 voxels of one byte under a mask of 64 bits. SSE2 is part of every x86-64
/// processor and AVX2 of most (processor.hpp); other machines run the scalar reference.
namespace voxnav::kernels {

/// The result of a subtraction from 64 voxels.
struct Subtracted {
  bool any_changed = false;
  unsigned crossed_free = 0;      ///< voxels that came below `free_end`
  unsigned crossed_occupied = 0;  ///< voxels that came below `occupied_min`
};

/// The result of a subtraction from a whole block of 16^3 voxels.
struct SubtractedBlock : Subtracted {
  unsigned num_asked = 0;  ///< bits that were set in the masks
};
constexpr int kBlockWords = 64;  ///< words of 64 bits, one bit for each voxel of a block

struct Subtraction {
  std::uint8_t amount;
  std::uint8_t free_end;
  std::uint8_t occupied_min;
};

namespace reference {

/// Sets cells[i] = max(0, cells[i] - amount) for every bit i that is set in the mask.
inline Subtracted subtract_where(std::uint8_t* cells, std::uint64_t mask, const Subtraction& by) {
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

/// Returns a mask in which bit i is set if cells[i] of 64 is at least `limit`, which may exceed the range of a byte.
inline std::uint64_t bits_at_least(const std::uint8_t* cells, int limit) {
  std::uint64_t out = 0;
  for (int i = 0; i < 64; ++i) out |= static_cast<std::uint64_t>(cells[i] >= limit ? 1 : 0) << i;
  return out;
}

/// Calls subtract_where() for each of the 64 words of a block.
inline SubtractedBlock subtract_in_block(std::uint8_t* cells, const std::uint64_t* masks, const Subtraction& by) {
  SubtractedBlock out;
  for (std::size_t word = 0; word < kBlockWords; ++word) {
    const Subtracted done = subtract_where(cells + 64 * word, masks[word], by);
    out.any_changed = out.any_changed || done.any_changed;
    out.crossed_free += done.crossed_free;
    out.crossed_occupied += done.crossed_occupied;
    out.num_asked += count_bits(masks[word]);
  }
  return out;
}

}  // namespace reference

SubtractedBlock subtract_in_block(std::uint8_t* cells, const std::uint64_t* masks, const Subtraction& by);

#if defined(__SSE2__)
namespace detail {

/// Returns a mask in which bit i is set if byte i of a is at least b.
VOXNAV_INLINE unsigned at_least(__m128i a, __m128i b) {
  return static_cast<unsigned>(_mm_movemask_epi8(_mm_cmpeq_epi8(_mm_max_epu8(a, b), a)));
}
/// Returns a mask in which bit i is set if byte i of a is less than b.
VOXNAV_WIDE VOXNAV_INLINE unsigned below(__m256i a, __m256i b) {
  return ~static_cast<unsigned>(_mm256_movemask_epi8(_mm256_cmpeq_epi8(_mm256_max_epu8(a, b), a)));
}

/// Returns bytes that are 0xFF where the bit of their number is set.
VOXNAV_INLINE __m128i bytes_of_bits(unsigned bits) {
  const __m128i bit_of_byte = _mm_set1_epi64x(static_cast<long long>(0x8040201008040201ull));
  const __m128i spread =
      _mm_unpacklo_epi64(_mm_set1_epi8(static_cast<char>(bits & 0xFFu)), _mm_set1_epi8(static_cast<char>(bits >> 8)));
  return _mm_cmpeq_epi8(_mm_and_si128(spread, bit_of_byte), bit_of_byte);
}

}  // namespace detail

VOXNAV_INLINE Subtracted subtract_where(std::uint8_t* cells, std::uint64_t mask, const Subtraction& by) {
  using namespace detail;  // NOLINT: parts of this function
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
    if (_mm_movemask_epi8(_mm_cmpeq_epi8(before, after)) == 0xFFFF) continue;  // all of them were zero before
    _mm_storeu_si128(at, after);
    out.any_changed = true;
    out.crossed_free += count_bits(at_least(before, free_limit) & ~at_least(after, free_limit));
    out.crossed_occupied += count_bits(at_least(before, occupied_limit) & ~at_least(after, occupied_limit));
  }
  return out;
}

/// The function above for callers that are marked VOXNAV_WIDE themselves.
VOXNAV_WIDE inline Subtracted subtract_where_wide(std::uint8_t* cells, std::uint64_t mask, const Subtraction& by) {
  using namespace detail;  // NOLINT: parts of this function
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
    if (_mm256_movemask_epi8(_mm256_cmpeq_epi8(before, after)) == -1) continue;  // all of them were zero before
    _mm256_storeu_si256(at, after);
    out.any_changed = true;
    out.crossed_free += count_bits(below(after, free_limit) & ~below(before, free_limit));
    out.crossed_occupied += count_bits(below(after, occupied_limit) & ~below(before, occupied_limit));
  }
  return out;
}
#else
inline Subtracted subtract_where(std::uint8_t* cells, std::uint64_t mask, const Subtraction& by) {
  return reference::subtract_where(cells, mask, by);
}
inline Subtracted subtract_where_wide(std::uint8_t* cells, std::uint64_t mask, const Subtraction& by) {
  return reference::subtract_where(cells, mask, by);
}
#endif

inline std::uint64_t bits_at_least(const std::uint8_t* cells, int limit) {
#if defined(__SSE2__)
  if (limit > 255) return 0;
  std::uint64_t out = 0;
  const __m128i limits = _mm_set1_epi8(static_cast<char>(limit));
  for (int i = 0; i < 64; i += 16) {
    const __m128i cell = _mm_loadu_si128(reinterpret_cast<const __m128i*>(cells + i));
    out |= std::uint64_t{detail::at_least(cell, limits)} << i;
  }
  return out;
#else
  return reference::bits_at_least(cells, limit);
#endif
}

}  // namespace voxnav::kernels
