// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "voxnav/pipeline/mapper_config.hpp"

namespace voxnav::pipeline {

/// Chooses which points of a scan are used if there is too little time for all: every second, fourth or eighth one.
/// Only if that is not enough, the queue of scans drops some. The decision follows from durations that the caller
/// measures.
class LoadControl {
 public:
  /// @throws base::ConfigError
  explicit LoadControl(const LoadControlConfig& config);

  /// Adds the duration of the work on the last scan, and the time since the scan before; unusable numbers are ignored.
  void add(double work_s, double period_s);
  int decimation() const { return decimation_; }
  /// Keeps every n-th row of an array with rows of `columns` numbers.
  template <class Number>
  void thin_out(std::size_t columns, std::vector<Number>* rows) const;

 private:
  LoadControlConfig config_;
  int decimation_ = 1;
  int num_calm_ = 0;
};

template <class Number>
void LoadControl::thin_out(std::size_t columns, std::vector<Number>* rows) const {
  const std::size_t count = rows->size() / columns;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; i += static_cast<std::size_t>(decimation_), ++kept) {
    for (std::size_t c = 0; c < columns; ++c) (*rows)[kept * columns + c] = (*rows)[i * columns + c];
  }
  rows->resize(kept * columns);
}

}  // namespace voxnav::pipeline
