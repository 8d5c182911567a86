// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace voxnav_simulation {

/// The streams of random numbers of a world. Each kind of object has its own, so that a change of one kind leaves the
/// others as they are.
enum Stream : std::uint64_t {
  kTerrainStream = 1,
  kTreeStream = 2,
  kBushStream = 3,
  kPoleStream = 4,
  kRockStream = 5,
  kWallStream = 6,
  kHouseStream = 7,
  kMoverStream = 8,
};

}  // namespace voxnav_simulation
