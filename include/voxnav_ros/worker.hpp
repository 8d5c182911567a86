// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace voxnav_ros {

/// A thread that runs tasks in the order in which they were added. At most `capacity` tasks wait. Tasks must not throw.
class Worker {
 public:
  explicit Worker(std::size_t capacity) : capacity_(capacity), thread_([this] { run(); }) {}
  /// Waits for the running task; tasks that still wait are dropped.
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// @return false if the queue is full; the task is then dropped
  bool push(std::function<void()> task);
  std::size_t size() const;

 private:
  void run();

  std::size_t capacity_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> tasks_;
  bool is_stopping_ = false;
  std::thread thread_;  // the last member, because it uses all of the above
};

}  // namespace voxnav_ros
