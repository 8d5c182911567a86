// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "voxnav/cloud/cloud_layout.hpp"

namespace voxnav::cloud {

/// Figures of the time field in a sample of a cloud's returns, in the unit of the field.
struct TimeSpread {
  std::size_t num_looked_at = 0;  ///< returns in the sample
  std::size_t num_sampled = 0;    ///< returns in the sample whose time is a number
  std::size_t num_distinct = 0;   ///< different times among them
  double num_returns = 0.0;       ///< estimated number of returns of the whole cloud
  double low = 0.0, high = 0.0;   ///< the shortest span that holds 90 % of the sampled times, and those close to it
  double median = 0.0;
  double coverage = 0.0;  ///< share of the directions around the sensor's z axis with returns, at least
  double span() const { return high - low; }
};

/// Reads a sample of a cloud's points, spread over its rows and columns. It keeps its memory from cloud to cloud.
class TimeSampler {
 public:
  /// @param num_points  the largest number of points that are read
  /// @param cloud       must have a time field
  TimeSpread sample(const RawCloudView& cloud, std::size_t num_points);

 private:
  void collect(const RawCloudView& cloud, std::size_t num_points);
  void unwrap(const FieldAccess& time);

  std::vector<double> times_;
  std::size_t num_looked_at_ = 0, num_returns_ = 0, num_directions_ = 0;
};

/// Returns true if the numbers of the field are 32-bit counters, which overflow.
inline bool is_counter(FieldType type) { return type == FieldType::kUint32 || type == FieldType::kInt32; }

/// Returns the difference of two numbers of a field, also if a counter overflowed between them.
double difference(double later, double earlier, FieldType type);

}  // namespace voxnav::cloud
