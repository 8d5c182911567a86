// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "contestants.hpp"
#include "flights.hpp"

namespace voxnav::benchmark {

/// What the maps believe and what was there, for scripts/dev/plot_local_map: float32 rows x y z in DIR/NAME.f32, and
/// x y z class of the true surface points of all scans in DIR/truth.f32.
void write_occupied(const std::string& dir, const Contestant& map);
void write_truth(const std::string& dir, const Flight& flight, std::size_t num_scans);

}  // namespace voxnav::benchmark
