// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Binaries run on every machine of their architecture, and a few inner loops are compiled a second time for
/// processors that can do more: a function `f_wide` marked VOXNAV_WIDE and one without, which both call the same
/// VOXNAV_INLINE body, and a choice by base::is_wide() where they are called. Fused multiply-add is left out, so that
/// both give the same floats.
#if defined(__x86_64__) && defined(__GNUC__)
#define VOXNAV_WIDE __attribute__((target("avx2,bmi,bmi2,lzcnt,popcnt")))
#else
#define VOXNAV_WIDE
#endif

#if defined(__GNUC__)
#define VOXNAV_INLINE inline __attribute__((always_inline))
/// The compiler must take a local array to be in memory, and not keep it in registers.
#define VOXNAV_IN_MEMORY(array) asm("" : "+m"(array))
#else
#define VOXNAV_INLINE inline
#define VOXNAV_IN_MEMORY(array)
#endif

namespace voxnav::base {

namespace detail {
extern bool uses_wide;
}

/// Whether functions marked VOXNAV_WIDE are to run. Not to be asked while static variables are still being made.
inline bool is_wide() { return detail::uses_wide; }
/// Says whether they shall; no effect where they cannot. So that tests reach both; not while others work.
void use_wide(bool use);

}  // namespace voxnav::base
