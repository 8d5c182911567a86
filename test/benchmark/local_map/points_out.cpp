// SPDX-License-Identifier: BSD-3-Clause
#include "points_out.hpp"

#include <algorithm>
#include <fstream>
#include <stdexcept>

namespace voxnav::benchmark {
namespace {

void write(const std::string& path, const std::vector<float>& values) {
  std::ofstream out(path, std::ios::binary);
  out.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(float)));
  if (!out) throw std::runtime_error("cannot write " + path + ": does its folder exist?");
}

}  // namespace

void write_occupied(const std::string& dir, const Contestant& map) {
  write(dir + "/" + map.name() + ".f32", map.occupied_centers());
}

void write_truth(const std::string& dir, const Flight& flight, std::size_t num_scans) {
  std::vector<float> rows;
  for (std::size_t i = 0; i < std::min(num_scans, flight.scans.size()); ++i) {
    const FlightScan& scan = flight.scans[i];
    for (std::size_t k = 0; k < scan.true_points_W.size(); ++k) {
      for (int axis = 0; axis < 3; ++axis) rows.push_back(static_cast<float>(scan.true_points_W[k][axis]));
      rows.push_back(static_cast<float>(scan.classes[k]));
    }
  }
  write(dir + "/truth.f32", rows);
}

}  // namespace voxnav::benchmark
