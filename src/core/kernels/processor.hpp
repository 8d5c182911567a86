// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The floor `kernels` holds the inner loops that work on several numbers at once. Each of them has a scalar twin in
/// the namespace `kernels::reference`, which says in plain C++ what the loop computes; test/unit/kernels holds every
/// compiled form of the loop against its twin, bit by bit.
///
/// Binaries run on every machine of their architecture, so the loops are compiled a second time for processors that
/// can do more: a function `f_wide` marked VOXNAV_WIDE and one without both call the same VOXNAV_INLINE body, and
/// kernels::is_wide() chooses between them where they are called. Fused multiply-add is left out, so that both forms
/// give the same floats. Vectors are never passed by value to or from a function marked VOXNAV_WIDE unless the other
/// side is marked too: compilers refuse it, because the two sides would pass them in different registers.
#if defined(__x86_64__) && defined(__GNUC__)
#define VOXNAV_WIDE __attribute__((target("avx2,bmi,bmi2,lzcnt,popcnt")))
#else
#define VOXNAV_WIDE
#endif

#if defined(__GNUC__)
#define VOXNAV_INLINE inline __attribute__((always_inline))
/// The compiler has to keep a local array in memory; it would otherwise take the lanes out of registers one by one.
#define VOXNAV_IN_MEMORY(array) asm("" : "+m"(array))
#else
#define VOXNAV_INLINE inline
#define VOXNAV_IN_MEMORY(array)
#endif

namespace voxnav::kernels {

namespace detail {
extern bool uses_wide;
}

/// Whether functions marked VOXNAV_WIDE are to run. Must not be asked while static variables are still being made.
inline bool is_wide() { return detail::uses_wide; }

/// Chooses whether functions marked VOXNAV_WIDE run; a processor that lacks their instructions never runs them. Tests
/// reach both forms by it. Must not be called while other threads run kernels.
void use_wide(bool use);

}  // namespace voxnav::kernels
