// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <atomic>
#include <numeric>
#include <set>
#include <stdexcept>

#include "base/worker_pool.hpp"

using voxnav::base::Share;
using voxnav::base::share_of;
using voxnav::base::SharedItems;
using voxnav::base::WorkerPool;

TEST(WorkerPool, EveryWorkerIsCalledOncePerRound) {
  for (const int size : {1, 2, 5}) {
    WorkerPool pool(size);
    ASSERT_EQ(pool.size(), size);
    std::vector<int> calls(static_cast<std::size_t>(size), 0);
    for (int round = 0; round < 200; ++round) pool.run([&](int worker) { ++calls[static_cast<std::size_t>(worker)]; });
    for (const int n : calls) EXPECT_EQ(n, 200);
  }
}

TEST(WorkerPool, RunReturnsWhenAllWorkIsDone) {
  WorkerPool pool(3);
  std::vector<long> items(10000);
  for (long round = 1; round <= 20; ++round) {
    pool.run([&](int worker) {
      const auto share = share_of(items.size(), worker, pool.size());
      for (std::size_t i = share.begin; i < share.end; ++i) items[i] += round;
    });
    EXPECT_EQ(std::accumulate(items.begin(), items.end(), 0L), 10000 * round * (round + 1) / 2);
  }
}

TEST(WorkerPool, ThreadsAreKeptAndTheCallerIsOneOfThem) {
  WorkerPool pool(3);
  std::vector<std::thread::id> first(3), second(3);
  pool.run([&](int worker) { first[static_cast<std::size_t>(worker)] = std::this_thread::get_id(); });
  pool.run([&](int worker) { second[static_cast<std::size_t>(worker)] = std::this_thread::get_id(); });
  EXPECT_EQ(first, second);
  EXPECT_EQ(first[0], std::this_thread::get_id());
  EXPECT_EQ(std::set<std::thread::id>(first.begin(), first.end()).size(), 3u);
}

TEST(WorkerPool, ExceptionsReachTheCallerAndThePoolGoesOn) {
  for (const int size : {1, 3}) {
    WorkerPool pool(size);
    const int thrower = size - 1;
    std::atomic<int> finished{0};
    const auto task = [&](int worker) {
      if (worker == thrower) throw std::runtime_error("worker " + std::to_string(worker));
      ++finished;
    };
    try {
      pool.run(task);
      ADD_FAILURE() << "nothing thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(error.what(), "worker " + std::to_string(thrower));
    }
    EXPECT_EQ(finished, size - 1) << "the others finish their part";
    pool.run([&](int) { ++finished; });
    EXPECT_EQ(finished, 2 * size - 1);
  }
}

TEST(WorkerPool, SharesCoverEverythingOnceInOrder) {
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{7}, std::size_t{1000}}) {
    for (int workers = 1; workers <= 9; ++workers) {
      std::size_t next = 0;
      for (int worker = 0; worker < workers; ++worker) {
        const auto share = share_of(count, worker, workers);
        EXPECT_EQ(share.begin, next);
        EXPECT_LE(share.end - share.begin, count / static_cast<std::size_t>(workers) + 1);
        next = share.end;
      }
      EXPECT_EQ(next, count);
    }
  }
}

TEST(SharedItems, EveryItemIsHandedOutOnce) {
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{7}, std::size_t{1000}}) {
    WorkerPool pool(4);
    SharedItems items(count, 3);
    std::vector<std::atomic<int>> taken(count);
    pool.run([&](int) {
      for (Share share; items.next(&share);) {
        for (std::size_t i = share.begin; i < share.end; ++i) ++taken[i];
      }
    });
    for (const auto& times : taken) EXPECT_EQ(times, 1);
  }
}
