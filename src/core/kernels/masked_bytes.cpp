// SPDX-License-Identifier: BSD-3-Clause
#include "kernels/masked_bytes.hpp"

namespace voxnav::kernels {
namespace {

VOXNAV_INLINE void add(const Subtracted& done, std::uint64_t mask, SubtractedBlock* out) {
  out->any_changed = out->any_changed || done.any_changed;
  out->crossed_free += done.crossed_free;
  out->crossed_occupied += done.crossed_occupied;
  out->num_asked += count_bits(mask);
}

SubtractedBlock subtract_plain(std::uint8_t* cells, const std::uint64_t* masks, const Subtraction& by) {
  SubtractedBlock out;
  for (std::size_t word = 0; word < kBlockWords; ++word) {
    if (masks[word] != 0) add(subtract_where(cells + 64 * word, masks[word], by), masks[word], &out);
  }
  return out;
}
VOXNAV_WIDE SubtractedBlock subtract_wide(std::uint8_t* cells, const std::uint64_t* masks, const Subtraction& by) {
  SubtractedBlock out;
  for (std::size_t word = 0; word < kBlockWords; ++word) {
    if (masks[word] != 0) add(subtract_where_wide(cells + 64 * word, masks[word], by), masks[word], &out);
  }
  return out;
}

}  // namespace

SubtractedBlock subtract_in_block(std::uint8_t* cells, const std::uint64_t* masks, const Subtraction& by) {
  return (is_wide() ? subtract_wide : subtract_plain)(cells, masks, by);
}

}  // namespace voxnav::kernels
