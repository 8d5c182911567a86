// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <cstdint>
#include <optional>
#include <vector>

#include "voxnav/base/config.hpp"
#include "voxnav/cloud/cloud_layout.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::cloud {

struct OpenBeamsConfig {
  bool is_enabled = false;
  int margin_rows = 2;
  int margin_columns = 4;
  int row_step = 2;
  int column_step = 4;

  template <class V>
  static void fields(V&& v) {
    using C = OpenBeamsConfig;
    v("is_enabled", &C::is_enabled, base::any(), "",
      "find open beams; they are sent with the points, and let the local map clear no_return_range_m");
    v("margin_rows", &C::margin_rows, base::in(0, 32), "", "a beam is open if no beam this near returned anything");
    v("margin_columns", &C::margin_columns, base::in(0, 64), "", "as margin_rows, for columns along a row");
    v("row_step", &C::row_step, base::in(1, 64), "", "only every n-th row is tested");
    v("column_step", &C::column_step, base::in(1, 64), "", "only every n-th beam of such a row is tested");
  }
};

/// Finds the beams of an organised scan that met nothing: the sky. A missing return alone says little (the surface may
/// be dark, wet or grazed), so a beam counts only when nothing around it returned either. A return that is missing has
/// no coordinates; where a beam points is learnt from the returns it gives at other times: one elevation and one
/// azimuth per row, columns evenly around the circle. Rows that never returned anything are extrapolated along a line.
/// Clouds with the fields beam_x, beam_y, beam_z tell the directions themselves (DepthCloud). Not thread-safe.
class OpenBeams {
 public:
  /// @throws base::ConfigError
  explicit OpenBeams(const OpenBeamsConfig& config = {});

  /// Learns from a scan and finds its open beams. O(points).
  /// @return unit directions, sensor frame; none for clouds that are not organised, until enough rows are known, and
  ///         for sensors whose columns are not spread evenly around the circle and whose clouds do not tell the
  ///         directions. Valid until the next call.
  const std::vector<geometry::Vec3f>& find(const RawCloudView& cloud);

 private:
  /// The directions of one row of the sensor, estimated from its returns.
  struct Row {
    std::complex<double> azimuth[2];  ///< sum of unit vectors at column 0, if columns turn left, right
    double elevation_rad = 0.0;       ///< sum
    double elevation_sq = 0.0;
    double count = 0.0;
  };
  struct Beam {
    double elevation_rad;
    double azimuth_rad;  ///< of column 0
  };
  void reset(std::uint32_t rows, std::uint32_t columns);
  void learn(const RawCloudView& cloud);
  void mark_returns(const RawCloudView& cloud);
  void find_told(const RawCloudView& cloud);
  bool choose_turn();
  void spread_to_all_rows();
  bool is_open(int row, int column) const;

  OpenBeamsConfig config_;
  std::uint32_t rows_ = 0, columns_ = 0;
  std::uint32_t phase_ = 0;
  int turn_ = 0;  ///< 0 left, 1 right
  std::vector<Row> seen_;
  std::vector<std::optional<Beam>> beams_;
  std::vector<std::uint8_t> is_near_return_;  ///< per pixel, along its row
  std::vector<geometry::Vec3f> directions_;
};

}  // namespace voxnav::cloud
