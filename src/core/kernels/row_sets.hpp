// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

/// Short loops over rows of numbers that RayMarks needs.
namespace voxnav::kernels {

struct Extent {
  float low, high;
};
/// Computes the lowest and the highest of n finite numbers and one more.
Extent extent_of(const float* numbers, std::size_t n, float other);

constexpr int kUnitedRows = 16;
/// Computes all[k], the bits that are set in word k of any of 16 rows. A row has `count` words, and rows are `step`
/// words apart.
void unite_rows(const std::uint32_t* first, std::size_t count, std::ptrdiff_t step, std::uint32_t* all);

namespace reference {
Extent extent_of(const float* numbers, std::size_t n, float other);
void unite_rows(const std::uint32_t* first, std::size_t count, std::ptrdiff_t step, std::uint32_t* all);
}  // namespace reference

}  // namespace voxnav::kernels
