// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_ros/worker.hpp"

namespace voxnav_ros {

Worker::~Worker() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

bool Worker::push(std::function<void()> task) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (tasks_.size() >= capacity_ || is_stopping_) return false;
    tasks_.push_back(std::move(task));
  }
  wake_.notify_one();
  return true;
}

std::size_t Worker::size() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return tasks_.size();
}

void Worker::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!is_stopping_) {
    if (tasks_.empty()) {
      wake_.wait(lock);
      continue;
    }
    const std::function<void()> task = std::move(tasks_.front());
    tasks_.pop_front();
    lock.unlock();
    task();
    lock.lock();
  }
}

}  // namespace voxnav_ros
