// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "contestants.hpp"
#include "flights.hpp"

namespace voxnav::benchmark {

/// Writes the occupied points of a map to DIR/NAME.f32 as float32 rows of x, y, z, for scripts/dev/plot_local_map.
void write_occupied(const std::string& dir, const Contestant& map);
/// Writes the true surface points of all scans to DIR/truth.f32 as float32 rows of x, y, z and class.
void write_truth(const std::string& dir, const Flight& flight, std::size_t num_scans);

}  // namespace voxnav::benchmark
