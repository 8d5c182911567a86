// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The floor `kernels` holds the inner loops that are written with vector instructions. Each of them has a scalar
/// reference in the namespace `kernels::reference`, plain C++ code that defines what the loop computes; the tests in
/// test/unit/kernels compare every compiled variant of the loop with its reference, bit by bit.
///
/// Binaries must run on every machine of their architecture, so the loops are compiled a second time for processors
/// with wider vectors (AVX2): a function `f_wide` marked VOXNAV_WIDE and one without the mark both call the same
/// VOXNAV_INLINE body, and the caller chooses between them by kernels::is_wide(). Fused multiply-add is not used, so
/// that both variants give the same floats. Vectors are never passed by value to or from a function marked VOXNAV_WIDE
/// unless the other side is marked too: compilers refuse it, because the two sides would use different registers.
#if defined(__x86_64__) && defined(__GNUC__)
#define VOXNAV_WIDE __attribute__((target("avx2,bmi,bmi2,lzcnt,popcnt")))
#else
#define VOXNAV_WIDE
#endif

#if defined(__GNUC__)
#define VOXNAV_INLINE inline __attribute__((always_inline))
/// Makes the compiler keep a local array in memory; it would otherwise extract the lanes of registers one by one.
#define VOXNAV_IN_MEMORY(array) asm("" : "+m"(array))
#else
#define VOXNAV_INLINE inline
#define VOXNAV_IN_MEMORY(array)
#endif

namespace voxnav::kernels {

namespace detail {
extern bool uses_wide;
}

/// Returns true if functions marked VOXNAV_WIDE shall run. It must not be called while static variables are being
/// initialised.
inline bool is_wide() { return detail::uses_wide; }

/// Chooses whether functions marked VOXNAV_WIDE run, so that tests reach both variants. A processor that lacks the
/// instructions never runs them. It must not be called while other threads run kernels.
void use_wide(bool use);

}  // namespace voxnav::kernels
