// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "flights.hpp"

namespace voxnav::benchmark {

/// A map that is measured. All of them get the same scans in the same order.
class Contestant {
 public:
  virtual ~Contestant() = default;
  virtual std::string name() const = 0;
  /// Inserts a scan. Only this call is timed; prepare() converts the cloud beforehand.
  virtual void insert(const FlightScan& scan) = 0;
  virtual void prepare(const FlightScan&) {}
  virtual std::size_t memory_bytes() const = 0;
  virtual std::optional<double> probability(const geometry::Vec3& point) const = 0;
  virtual double free_threshold() const = 0;
  virtual std::vector<float> occupied_centers() const = 0;
  virtual std::vector<float> surface_points() const = 0;
};

/// Returns a LocalMap with hit probability 0.7, miss probability 0.4 and a window of 80 x 80 x 40 m.
/// @param every  only every n-th point of a scan is used, as on an overloaded machine
std::unique_ptr<Contestant> make_voxnav(double resolution_m, double max_range_m, int num_threads, int every = 1);
/// Returns an OctoMap that is filled by insertPointCloud() with discretize; its own threshold of 0.5 decides what is
/// free.
std::unique_ptr<Contestant> make_octomap(double resolution_m, double max_range_m);

}  // namespace voxnav::benchmark
