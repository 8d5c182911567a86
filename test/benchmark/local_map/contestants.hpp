// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "flights.hpp"

namespace voxnav::benchmark {

/// A map that is measured; all of them get the same scans in the same order.
class Contestant {
 public:
  virtual ~Contestant() = default;
  virtual std::string name() const = 0;
  /// Only this is timed; a cloud in the form the map wants is made by prepare().
  virtual void insert(const FlightScan& scan) = 0;
  virtual void prepare(const FlightScan&) {}
  virtual std::size_t memory_bytes() const = 0;
  virtual std::optional<double> probability(const geometry::Vec3& point) const = 0;
  virtual double free_threshold() const = 0;
  virtual std::vector<float> occupied_centers() const = 0;
  virtual std::vector<float> surface_points() const = 0;
};

/// hit 0.7, miss 0.4, 80 x 80 x 40 m. `every`: only every n-th point of a scan is used, as on an overloaded machine.
std::unique_ptr<Contestant> make_voxnav(double resolution_m, double max_range_m, int num_threads, int every = 1);
/// insertPointCloud with discretize; free is what its own threshold of 0.5 makes free.
std::unique_ptr<Contestant> make_octomap(double resolution_m, double max_range_m);

}  // namespace voxnav::benchmark
