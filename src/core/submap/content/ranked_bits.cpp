// SPDX-License-Identifier: BSD-3-Clause
#include "submap/content/ranked_bits.hpp"

#include <utility>

namespace voxnav::submap {

void RankedBits::finish() {
  words_.shrink_to_fit();
  before_.clear();
  before_.reserve(words_.size());
  count_ = 0;
  for (const std::uint64_t word : words_) {
    before_.push_back(static_cast<std::uint32_t>(count_));
    count_ += kernels::count_bits(word);
  }
}

bool RankedBits::assign(std::vector<std::uint64_t> words, std::size_t size, std::size_t count) {
  if (words.size() != (size + 63) / 64) return false;
  if (size % 64 != 0 && (words.back() >> (size % 64)) != 0) return false;
  words_ = std::move(words);
  size_ = size;
  finish();
  return count_ == count;
}

}  // namespace voxnav::submap
