// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/base/processor.hpp"

namespace voxnav::base::detail {

#if defined(__x86_64__) && defined(__GNUC__)
const bool kIsWide = __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("bmi") != 0 &&
                     __builtin_cpu_supports("bmi2") != 0 && __builtin_cpu_supports("popcnt") != 0;
#else
const bool kIsWide = false;
#endif

}  // namespace voxnav::base::detail
