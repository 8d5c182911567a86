// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace voxnav::base {

/// Threads that wait for work, so that a parallel step of a few hundred microseconds is not spent on starting them.
/// Only one thread at a time may call.
class WorkerPool {
 public:
  /// The calling thread works, too, so num_workers - 1 threads are started.
  explicit WorkerPool(int num_workers);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int size() const { return static_cast<int>(threads_.size()) + 1; }
  /// Calls task(0) .. task(size - 1), each on a thread of its own, and returns when all are done. The first exception
  /// that a task throws is thrown again here.
  void run(const std::function<void(int)>& task);

 private:
  void serve(int worker);
  void call(const std::function<void(int)>& task, int worker);

  std::mutex mutex_;
  std::condition_variable start_, done_;
  const std::function<void(int)>* task_ = nullptr;
  std::uint64_t round_ = 0;
  int num_busy_ = 0;
  bool is_ending_ = false;
  std::exception_ptr error_;
  std::vector<std::thread> threads_;
};

/// The items that fall to one of several workers when `count` items are split evenly.
struct Share {
  std::size_t begin;
  std::size_t end;
};
inline Share share_of(std::size_t count, int worker, int num_workers) {
  const auto part = [&](int i) { return count * static_cast<std::size_t>(i) / static_cast<std::size_t>(num_workers); };
  return {part(worker), part(worker + 1)};
}

/// Hands items out in order, `step` at a time, to whichever thread asks next. This suits items of very different cost.
/// Which thread gets which item is up to chance, so results must not depend on it.
class SharedItems {
 public:
  SharedItems(std::size_t count, std::size_t step) : count_(count), step_(step) {}
  /// Gives the next items; false when nothing is left.
  bool next(Share* share) {
    share->begin = next_.fetch_add(step_);
    share->end = std::min(count_, share->begin + step_);
    return share->begin < count_;
  }

 private:
  std::size_t count_, step_;
  std::atomic<std::size_t> next_{0};
};

}  // namespace voxnav::base
