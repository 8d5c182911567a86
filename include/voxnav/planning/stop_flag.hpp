// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>

namespace voxnav::planning {

/// Cancels a search from another thread, for callers that measure its time by a clock of their own. Thread-safe.
class StopFlag {
 public:
  void raise() { is_raised_ = true; }
  bool is_raised() const { return is_raised_; }

 private:
  std::atomic<bool> is_raised_{false};
};

}  // namespace voxnav::planning
