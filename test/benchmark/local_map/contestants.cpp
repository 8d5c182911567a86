// SPDX-License-Identifier: BSD-3-Clause
#include "contestants.hpp"

#include <octomap/octomap.h>

#include <cmath>

#include "occupancy/log_odds.hpp"
#include "voxnav/occupancy/local_map.hpp"

namespace voxnav::benchmark {
namespace {

using geometry::Vec3;

class Voxnav : public Contestant {
 public:
  Voxnav(const occupancy::LocalMapConfig& config, int every) : map_(config), every_(every) {}
  std::string name() const override {
    const int threads = map_.config().num_threads;
    if (every_ > 1) return "voxnav, 1 of " + std::to_string(every_);
    return threads == 1 ? "voxnav" : "voxnav, " + std::to_string(threads) + " threads";
  }
  void prepare(const FlightScan& scan) override {
    points_.clear();
    for (std::size_t i = 0; i < scan.points.size(); i += 3 * static_cast<std::size_t>(every_)) {
      points_.insert(points_.end(), scan.points.begin() + static_cast<std::ptrdiff_t>(i),
                     scan.points.begin() + static_cast<std::ptrdiff_t>(i) + 3);
    }
  }
  void insert(const FlightScan& scan) override { map_.insert(geometry::view_of_rows(points_), scan.T_W_L); }
  std::size_t memory_bytes() const override { return map_.memory_bytes(); }
  std::optional<double> probability(const Vec3& point) const override {
    const auto log_odds = map_.log_odds(point);
    return log_odds ? std::optional<double>(occupancy::probability_of(*log_odds)) : std::nullopt;
  }
  double free_threshold() const override { return map_.config().free_threshold; }
  std::vector<float> occupied_centers() const override { return map_.centers_above(map_.config().occupied_threshold); }
  std::vector<float> surface_points() const override { return map_.occupied_points(); }

 private:
  occupancy::LocalMap map_;
  int every_;
  std::vector<float> points_;
};

class Octomap : public Contestant {
 public:
  Octomap(double resolution_m, double max_range_m) : tree_(resolution_m), max_range_m_(max_range_m) {
    tree_.setProbHit(0.7);
    tree_.setProbMiss(0.4);
  }
  std::string name() const override { return "OctoMap"; }
  void prepare(const FlightScan& scan) override {
    cloud_.clear();
    for (std::size_t i = 0; i < scan.points.size(); i += 3) {
      const Vec3 p = scan.T_W_L * Vec3(scan.points[i], scan.points[i + 1], scan.points[i + 2]);
      cloud_.push_back(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
    }
  }
  void insert(const FlightScan& scan) override {
    const geometry::Vec3f o = scan.T_W_L.translation().cast<float>();
    tree_.insertPointCloud(cloud_, octomap::point3d(o.x(), o.y(), o.z()), max_range_m_, false, true);
  }
  std::size_t memory_bytes() const override { return tree_.memoryUsage(); }
  std::optional<double> probability(const Vec3& point) const override {
    const octomap::OcTreeNode* node = tree_.search(point.x(), point.y(), point.z());
    return node ? std::optional<double>(node->getOccupancy()) : std::nullopt;
  }
  double free_threshold() const override { return 0.5; }
  std::vector<float> occupied_centers() const override {
    std::vector<float> out;
    for (auto leaf = tree_.begin_leafs(); leaf != tree_.end_leafs(); ++leaf) {
      if (!tree_.isNodeOccupied(*leaf)) continue;
      const int n = static_cast<int>(std::lround(leaf.getSize() / tree_.getResolution()));
      for (int i = 0; i < n * n * n; ++i) {
        const double c[3] = {leaf.getX(), leaf.getY(), leaf.getZ()};
        const int at[3] = {i % n, i / n % n, i / n / n};
        for (int axis = 0; axis < 3; ++axis) {
          out.push_back(static_cast<float>(c[axis] + (at[axis] - 0.5 * (n - 1)) * tree_.getResolution()));
        }
      }
    }
    return out;
  }
  std::vector<float> surface_points() const override { return occupied_centers(); }

 private:
  octomap::OcTree tree_;
  double max_range_m_;
  octomap::Pointcloud cloud_;
};

}  // namespace

std::unique_ptr<Contestant> make_voxnav(double resolution_m, double max_range_m, int num_threads, int every) {
  occupancy::LocalMapConfig config;
  config.resolution_m = resolution_m;
  config.max_range_m = max_range_m;
  config.num_threads = num_threads;
  return std::make_unique<Voxnav>(config, every);
}

std::unique_ptr<Contestant> make_octomap(double resolution_m, double max_range_m) {
  return std::make_unique<Octomap>(resolution_m, max_range_m);
}

}  // namespace voxnav::benchmark
