// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"

namespace voxnav::occupancy {

/// Parameters of LocalMap. Probabilities are turned into log-odds steps by LogOddsScale.
struct LocalMapConfig {
  double resolution_m = 0.4;
  std::array<double, 3> window_size_m{80.0, 80.0, 40.0};
  double max_range_m = 26.0;
  double min_range_m = 0.0;
  double prob_hit = 0.7;
  double prob_miss = 0.4;
  double prob_clamp_min = 0.1192;
  double prob_clamp_max = 0.971;
  double occupied_threshold = 0.8;
  double free_threshold = 0.3;
  bool clear_beyond_range = true;
  double no_return_range_m = 0.2;
  double guard_sigmas = 2.0;
  double guard_spread_voxels = 0.05;
  double guard_end_voxels = 1.5;
  int guard_octants = 8;
  int guard_patience = 8;
  int num_threads = 1;
  double max_memory_mb = 4096.0;
  int max_evicted_blocks = 4096;

  template <class V>
  static void fields(V&& v) {
    using C = LocalMapConfig;
    using base::in;
    v("resolution_m", &C::resolution_m, in(0.01, 10.0), "m", "edge of one voxel");
    v("window_size_m", &C::window_size_m, in(0.1, 10000.0), "m", "x, y, z extent kept around the sensor");
    v("max_range_m", &C::max_range_m, in(0.1, 1000.0), "m", "longest ray; farther points only clear up to here");
    v("min_range_m", &C::min_range_m, in(0.0, 100.0), "m", "nearer points are dropped and counted");
    v("prob_hit", &C::prob_hit, in(0.51, 0.99), "", "probability of occupied after one hit on an unknown voxel");
    v("prob_miss", &C::prob_miss, in(0.01, 0.49), "", "probability of occupied after one miss on an unknown voxel");
    v("prob_clamp_min", &C::prob_clamp_min, in(0.001, 0.49), "", "lowest probability of a voxel");
    v("prob_clamp_max", &C::prob_clamp_max, in(0.51, 0.999), "", "highest probability of a voxel");
    v("occupied_threshold", &C::occupied_threshold, in(0.5, 0.99), "", "occupied above, not at, this probability");
    v("free_threshold", &C::free_threshold, in(0.01, 0.5), "", "free below, not at, this probability");
    v("clear_beyond_range", &C::clear_beyond_range, base::any(), "",
      "points beyond max_range_m clear the ray up to it");
    v("no_return_range_m", &C::no_return_range_m, in(0.0, 1000.0), "m",
      "beams without return clear this far (they may be dark, not empty), never an occupied voxel");
    v("guard_sigmas", &C::guard_sigmas, in(0.0, 10.0), "",
      "a beam counts against a voxel that holds hits only if it passes within this many standard deviations of them");
    v("guard_spread_voxels", &C::guard_spread_voxels, in(0.01, 1.0), "voxel",
      "noise added to the standard deviation of the hits");
    v("guard_end_voxels", &C::guard_end_voxels, in(0.0, 10.0), "voxel",
      "a beam counts only if it ends at least this far behind the hits");
    v("guard_octants", &C::guard_octants, in(1, 8), "",
      "beams that pass farther off count once they together went through this many octants of the voxel without a hit");
    v("guard_patience", &C::guard_patience, in(0, 100), "",
      "at most this many scans that saw through a voxel are forgiven because hits followed as many before (leaves)");
    v("num_threads", &C::num_threads, in(1, 64), "", "threads of one insertion; the result does not depend on it");
    v("max_memory_mb", &C::max_memory_mb, in(1.0, 1.0e6), "MB", "a window that could need more is refused");
    v("max_evicted_blocks", &C::max_evicted_blocks, in(0, 1.0e6), "",
      "blocks kept for take_evicted(); further ones are dropped and counted");
  }
  std::vector<std::string> problems() const;

  /// The number of blocks along each axis of the window. It is always odd, and the sensor stays in or next to the
  /// middle block.
  std::array<int, 3> window_blocks() const;
  /// The upper bound of the memory that a map of this configuration can allocate, without some bytes for each point of
  /// a scan.
  double worst_case_bytes() const;
};

/// How far the sensor of a scan is believed, within what the configuration of the map allows.
struct ScanLimits {
  double max_range_m = std::numeric_limits<double>::infinity();        ///< farther points only clear up to here
  double no_return_range_m = std::numeric_limits<double>::infinity();  ///< beams without return clear up to here
  /// Standard deviation of a range. A beam counts against hits that are known only if it ends another two of these
  /// behind them, because it may have ended at them.
  double range_noise_m = 0.0;
};

}  // namespace voxnav::occupancy
