// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

namespace voxnav::base {

/// Time stamps are integer nanoseconds. Python and text files use seconds, which are converted where they come in.
using StampNs = std::int64_t;

inline double to_seconds(StampNs stamp_ns) { return static_cast<double>(stamp_ns) * 1e-9; }
inline StampNs from_seconds(double seconds) { return static_cast<StampNs>(std::llround(seconds * 1e9)); }

}  // namespace voxnav::base
