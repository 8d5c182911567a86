// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "voxnav/cloud/cloud_layout.hpp"

namespace voxnav::cloud {

/// What a sample of a cloud's returns says about its time field, in the numbers of the field.
struct TimeSpread {
  std::size_t num_looked_at = 0;  ///< returns in the sample
  std::size_t num_sampled = 0;    ///< those whose time is a number
  std::size_t num_distinct = 0;   ///< different times among them
  double num_returns = 0.0;       ///< of the whole cloud, estimated
  double low = 0.0, high = 0.0;   ///< the shortest span that holds 90 % of the sampled times, and those close to it
  double median = 0.0;
  double coverage = 0.0;  ///< share of the directions around the sensor's z axis with returns, at least
  double span() const { return high - low; }
};

/// Looks at a sample of a cloud's points, spread over its rows and columns. Keeps its memory from cloud to cloud.
class TimeSampler {
 public:
  /// @param num_points  at most so many are looked at
  /// @param cloud       has a time field
  TimeSpread sample(const RawCloudView& cloud, std::size_t num_points);

 private:
  void collect(const RawCloudView& cloud, std::size_t num_points);
  void unwrap(const FieldAccess& time);

  std::vector<double> times_;
  std::size_t num_looked_at_ = 0, num_returns_ = 0, num_directions_ = 0;
};

/// Whether numbers of the field are counters of 32 bits, which begin anew when they are full.
inline bool is_counter(FieldType type) { return type == FieldType::kUint32 || type == FieldType::kInt32; }

/// The difference of two numbers of a field, with regard to counters that began anew in between.
double difference(double later, double earlier, FieldType type);

}  // namespace voxnav::cloud
