// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace voxnav_simulation {

/// Random streams of a world: each kind of object draws from its own.
enum Stream : std::uint64_t {
  kTerrainStream = 1,
  kTreeStream = 2,
  kBushStream = 3,
  kPoleStream = 4,
  kRockStream = 5,
  kWallStream = 6,
  kHouseStream = 7,
};

}  // namespace voxnav_simulation
