// SPDX-License-Identifier: BSD-3-Clause
#include "kernels/row_sets.hpp"

#include <algorithm>
#include <cstring>

#include "kernels/lanes.hpp"

namespace voxnav::kernels {
namespace {

VOXNAV_INLINE void unite(const std::uint32_t* first, std::size_t count, std::ptrdiff_t step, std::uint32_t* all) {
  std::memcpy(all, first, count * sizeof *all);
  for (int i = 1; i < kUnitedRows; ++i) {
    const std::uint32_t* next = first + i * step;
    for (std::size_t k = 0; k < count; ++k) all[k] |= next[k];
  }
}
void unite_plain(const std::uint32_t* first, std::size_t count, std::ptrdiff_t step, std::uint32_t* all) {
  unite(first, count, step, all);
}
VOXNAV_WIDE void unite_wide(const std::uint32_t* first, std::size_t count, std::ptrdiff_t step, std::uint32_t* all) {
  unite(first, count, step, all);
}

}  // namespace

Extent extent_of(const float* numbers, std::size_t n, float other) {
  using namespace lanes;  // NOLINT: the vector types of this function
  const float* const end = numbers + n;
  Floats low = Floats{} + other, high = low;
  for (; end - numbers >= kLanes; numbers += kLanes) {
    low = smaller(low, loaded<Floats>(numbers));
    high = larger(high, loaded<Floats>(numbers));
  }
  Extent out{other, other};
  for (int i = 0; i < kLanes; ++i) {
    const float lane_low = low[i], lane_high = high[i];
    out = {std::min(out.low, lane_low), std::max(out.high, lane_high)};
  }
  for (; numbers < end; ++numbers) out = {std::min(out.low, *numbers), std::max(out.high, *numbers)};
  return out;
}

void unite_rows(const std::uint32_t* first, std::size_t count, std::ptrdiff_t step, std::uint32_t* all) {
  (is_wide() ? unite_wide : unite_plain)(first, count, step, all);
}

Extent reference::extent_of(const float* numbers, std::size_t n, float other) {
  Extent out{other, other};
  for (std::size_t i = 0; i < n; ++i) out = {std::min(out.low, numbers[i]), std::max(out.high, numbers[i])};
  return out;
}

void reference::unite_rows(const std::uint32_t* first, std::size_t count, std::ptrdiff_t step, std::uint32_t* all) {
  for (std::size_t k = 0; k < count; ++k) {
    all[k] = 0;
    for (int i = 0; i < kUnitedRows; ++i) all[k] |= first[i * step + static_cast<std::ptrdiff_t>(k)];
  }
}

}  // namespace voxnav::kernels
