// SPDX-License-Identifier: BSD-3-Clause
#include "kernels/processor.hpp"

namespace voxnav::kernels {
namespace {

bool can_use_wide() {
#if defined(__x86_64__) && defined(__GNUC__)
  __builtin_cpu_init();  // static variables may be initialised before the library that calls it
  return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("bmi") != 0 &&
         __builtin_cpu_supports("bmi2") != 0 && __builtin_cpu_supports("popcnt") != 0;
#else
  return false;
#endif
}

}  // namespace

bool detail::uses_wide = can_use_wide();

void use_wide(bool use) { detail::uses_wide = use && can_use_wide(); }

}  // namespace voxnav::kernels
