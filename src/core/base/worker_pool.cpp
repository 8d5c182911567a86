// SPDX-License-Identifier: BSD-3-Clause
#include "base/worker_pool.hpp"

namespace voxnav::base {

WorkerPool::WorkerPool(int num_workers) {
  for (int worker = 1; worker < num_workers; ++worker) threads_.emplace_back([this, worker] { serve(worker); });
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_ending_ = true;
  }
  start_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void WorkerPool::run(const std::function<void(int)>& task) {
  if (threads_.empty()) return task(0);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    task_ = &task;
    ++round_;
    num_busy_ = static_cast<int>(threads_.size());
  }
  start_.notify_all();
  call(task, 0);
  std::unique_lock<std::mutex> lock(mutex_);
  done_.wait(lock, [this] { return num_busy_ == 0; });
  const std::exception_ptr error = error_;
  error_ = nullptr;
  if (error) std::rethrow_exception(error);
}

void WorkerPool::call(const std::function<void(int)>& task, int worker) {
  try {
    task(worker);
  } catch (...) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!error_) error_ = std::current_exception();
  }
}

void WorkerPool::serve(int worker) {
  std::uint64_t served = 0;
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    start_.wait(lock, [&] { return is_ending_ || round_ != served; });
    if (is_ending_) return;
    served = round_;
    const std::function<void(int)>& task = *task_;
    lock.unlock();
    call(task, worker);
    lock.lock();
    if (--num_busy_ == 0) done_.notify_one();
  }
}

}  // namespace voxnav::base
