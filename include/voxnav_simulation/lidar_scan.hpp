// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace voxnav_simulation {

/// Labels for the origin of a return, beside those of SurfaceClass.
inline constexpr std::uint8_t kLabelOwnBody = 100;
inline constexpr std::uint8_t kLabelGhost = 101;
inline constexpr std::uint8_t kLabelRain = 102;
inline constexpr std::uint8_t kLabelSpeckle = 103;  ///< dust, or the noise of sunlight
inline constexpr std::uint8_t kLabelNone = 255;     ///< no return

/// One turn of the sensor as an image. Row 0 is the top beam. Column 0 is measured first and looks backwards; the
/// columns follow clockwise as seen from above, as with Ouster sensors. Pixel (row, column) is at index
/// row * columns + column.
struct LidarScan {
  int rows = 0;
  int columns = 0;
  std::vector<std::array<float, 4>> points;  ///< x, y, z in the sensor frame at the column's time, intensity; 0 = none
  std::vector<float> ranges_m;               ///< 0 = no return
  std::vector<float> reflectivity;           ///< estimate from signal and range, 0 to 255
  std::vector<std::uint8_t> labels;
  std::vector<std::uint32_t> column_times_ns;  ///< after the start of the turn, one per column

  std::size_t index(int row, int column) const { return static_cast<std::size_t>(row) * columns + column; }
};

}  // namespace voxnav_simulation
