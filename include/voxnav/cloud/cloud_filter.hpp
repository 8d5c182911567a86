// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "voxnav/cloud/body_mask.hpp"
#include "voxnav/cloud/cloud_filter_config.hpp"
#include "voxnav/cloud/cloud_layout.hpp"
#include "voxnav/cloud/point_times.hpp"

namespace voxnav::cloud {

/// One filtered return, in the byte layout of `cloud_filter/points`: it is copied to messages as it stands.
struct Point {
  float x = 0.0F;                    ///< m, sensor frame
  float y = 0.0F;                    ///< m
  float z = 0.0F;                    ///< m
  float intensity = 0.0F;            ///< as the sensor gives it; 0 when it gives none
  std::uint32_t time_offset_ns = 0;  ///< after the start of the sweep
};
static_assert(sizeof(Point) == 20 && std::is_trivially_copyable_v<Point>);

/// Counts of the points of one cloud by the reason for which they were removed. Reasons are tried in this order, and
/// each point counts once.
struct FilterCounts {
  std::uint64_t total = 0;
  std::uint64_t decimated = 0;
  std::uint64_t nan = 0;   ///< a coordinate is NaN or infinite
  std::uint64_t zero = 0;  ///< (0, 0, 0): "no return" in Gazebo and several drivers
  std::uint64_t body = 0;
  std::uint64_t near = 0;
  std::uint64_t far = 0;
  std::uint64_t ghost = 0;
  std::uint64_t outlier = 0;
  std::uint64_t pcl = 0;  ///< dropped or merged by a filter of PCL, where there are any behind the CloudFilter
  std::uint64_t kept = 0;

  /// Name and value of every count but `total`, to which they sum up.
  std::array<std::pair<const char*, std::uint64_t>, 10> reasons() const;
  FilterCounts& operator+=(const FilterCounts& other);
};

struct FilterResult {
  std::vector<Point> points;
  std::vector<Point> ghosts;  ///< dropped for their intensity
  std::vector<Point> far;     ///< dropped for their range: they show free space, not surfaces
  FilterCounts counts;
  /// Time of the sweep's start after the cloud's stamp; negative for drivers that stamp the end.
  std::int64_t sweep_start_ns = 0;
  std::uint64_t num_bad_times = 0;         ///< kept points whose time is none of the sweep and is taken as 0
  bool is_ghost_filter_suspended = false;  ///< no return had any intensity, so that none could be judged by it
  /// Most returns have no neighbours in the image, so that lone ones tell nothing: none was removed as an outlier.
  bool is_outlier_filter_suspended = false;
};

/// Removes from a scan what is not surroundings: missing returns, the UAV's own body, ghosts, surplus.
/// One pass over the bytes, no allocation per point once the result has grown to the sensor's size.
/// Filters the clouds of one sensor. It remembers the reading of their point times and the phase of decimation. Not
/// thread-safe.
class CloudFilter {
 public:
  /// @throws base::ConfigError
  explicit CloudFilter(const CloudFilterConfig& config);

  const CloudFilterConfig& config() const { return config_; }

  /// Returns that the mask covers count as body, beside those of the configured sphere and box.
  void set_body_mask(BodyMask mask);

  /// Filters one cloud; `result` is overwritten, its memory reused. O(points).
  void apply(const RawCloudView& cloud, FilterResult* result);
  FilterResult apply(const RawCloudView& cloud);

  /// The reading of the sensor's point times after the clouds so far.
  const TimesReport& point_times() const { return times_.report(); }

  /// The reason for which a point is removed, or that it is kept.
  enum class Verdict { kKept, kNan, kZero, kBody, kNear, kFar, kGhost };

 private:
  struct Limits {
    float clear_sq, far_sq, near_sq, ghost_sq;  // squared ranges, m^2
    float ghost_intensity;
    std::array<float, 3> center;
    float body_sq;
    std::array<float, 3> box_min, box_max;
  };
  static Limits limits_of(const CloudFilterConfig& config);
  Verdict judge_near_or_odd(float x, float y, float z, float range_sq) const;
  template <class Reader>
  void pass(const RawCloudView& cloud, FilterResult* result);
  template <class Reader, bool kMayHaveGhosts>
  void pass_rows(const RawCloudView& cloud, FilterResult* result);
  void begin(const RawCloudView& cloud, FilterResult* result);
  void restore_unjudged_ghosts(FilterResult* result);
  void remove_outliers(FilterResult* result);
  bool has_neighbours(std::size_t point, const std::vector<Point>& points) const;
  bool knows_image(const std::vector<Point>& points);

  CloudFilterConfig config_;
  Limits limits_;
  PointTimes times_;
  CloudTimes cloud_times_;  // of the present cloud
  BodyMask body_mask_;
  bool has_body_mask_ = false;
  std::uint32_t row_step_ = 1, column_step_ = 1;    // of the present cloud
  std::uint32_t first_row_ = 0, first_column_ = 0;  // decimation phase
  std::uint64_t num_clouds_ = 0;
  std::uint32_t grid_rows_ = 0, grid_columns_ = 0;
  std::vector<std::int32_t> grid_;  // kept point of each pixel, -1 = none; only for outlier removal
  std::vector<std::uint32_t> pixel_of_, ghost_pixel_of_;  // pixel of each kept point, of each ghost
  std::vector<char> is_outlier_;
  bool knows_image_ = false;  // returns of this sensor that neighbour each other in the image do so in space
};

}  // namespace voxnav::cloud
