// SPDX-License-Identifier: BSD-3-Clause
/// Each filter of PCL against a brute-force version of what its name promises.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <tuple>

#include "voxnav/cloud/pcl_filters.hpp"

using namespace voxnav::cloud;  // NOLINT: test

namespace {

Eigen::Vector3f position(const Point& p) { return {p.x, p.y, p.z}; }

/// A ground at z = -1.5 with a box on it, and points all around.
FilterResult some_cloud(std::uint32_t seed, std::size_t num_points) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> in(-8.0F, 8.0F), noise(-0.02F, 0.02F);
  FilterResult out;
  for (std::size_t i = 0; i < num_points; ++i) {
    Point p;
    p.x = in(random);
    p.y = in(random);
    p.z = i % 3 == 0 ? -1.5F + noise(random) : 0.3F * in(random) + 1.5F;
    p.intensity = static_cast<float>(random() % 100);
    p.time_offset_ns = static_cast<std::uint32_t>(random() % 100000000);
    out.points.push_back(p);
  }
  out.counts.total = out.counts.kept = num_points;
  return out;
}

FilterResult filtered(const FilterResult& before, const PclFiltersConfig& config) {
  FilterResult out = before;
  for (const auto& filter : make_pcl_filters(config)) filter->apply(&out);
  std::uint64_t sum = 0;
  for (const auto& [name, count] : out.counts.reasons()) sum += count;
  EXPECT_EQ(sum, out.counts.total);
  EXPECT_EQ(out.counts.kept, out.points.size());
  return out;
}

bool is_same(const Point& a, const Point& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z && a.intensity == b.intensity && a.time_offset_ns == b.time_offset_ns;
}

/// Points that are kept stay in their order, with intensity and time.
void expect_kept(const FilterResult& before, const FilterResult& after, const std::function<bool(std::size_t)>& keeps) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < before.points.size(); ++i) {
    if (!keeps(i)) continue;
    ASSERT_LT(next, after.points.size());
    ASSERT_TRUE(is_same(before.points[i], after.points[next++])) << i;
  }
  EXPECT_EQ(next, after.points.size());
}

std::vector<float> distances_from(const std::vector<Point>& points, std::size_t i) {
  std::vector<float> out;
  for (std::size_t j = 0; j < points.size(); ++j) {
    if (j != i) out.push_back((position(points[j]) - position(points[i])).norm());
  }
  std::sort(out.begin(), out.end());
  return out;
}

PclFiltersConfig chain(const std::vector<std::string>& filters) {
  PclFiltersConfig config;
  config.filters = filters;
  return config;
}

/// Means of the points in each cube, by definition.
std::map<std::tuple<int, int, int>, std::vector<Point>> cubes_of(const std::vector<Point>& points, double leaf) {
  const float inverse = 1.0F / static_cast<float>(leaf);
  std::map<std::tuple<int, int, int>, std::vector<Point>> out;
  for (const Point& p : points) {
    const Eigen::Vector3i cell = (position(p) * inverse).array().floor().cast<int>();
    out[{cell.x(), cell.y(), cell.z()}].push_back(p);
  }
  return out;
}

void expect_means(const FilterResult& before, const FilterResult& after, double leaf, std::size_t least) {
  auto cubes = cubes_of(before.points, leaf);
  for (auto it = cubes.begin(); it != cubes.end();) it = it->second.size() < least ? cubes.erase(it) : std::next(it);
  ASSERT_EQ(after.points.size(), cubes.size());
  for (const auto& [cell, members] : cubes_of(after.points, leaf)) {
    ASSERT_EQ(members.size(), 1u);
    const auto found = cubes.find(cell);
    ASSERT_NE(found, cubes.end());
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    double intensity = 0.0, time_ns = 0.0;
    for (const Point& p : found->second) {
      mean += position(p).cast<double>() / static_cast<double>(found->second.size());
      intensity += p.intensity / static_cast<double>(found->second.size());
      time_ns += p.time_offset_ns / static_cast<double>(found->second.size());
    }
    ASSERT_LT((position(members[0]).cast<double>() - mean).norm(), 1e-4);
    ASSERT_NEAR(members[0].intensity, intensity, 1e-3);
    ASSERT_NEAR(members[0].time_offset_ns, time_ns, 50.0);
  }
}

}  // namespace

TEST(PclFilters, PassThroughKeepsWhatIsWithinTheLimits) {
  const FilterResult before = some_cloud(1, 2000);
  for (const bool is_negative : {false, true}) {
    PclFiltersConfig config = chain({"pass_through"});
    config.filter_field_name = PclField::kIntensity;
    config.filter_limit_min = 20.0;
    config.filter_limit_max = 60.0;
    config.filter_limit_negative = is_negative;
    expect_kept(before, filtered(before, config), [&](std::size_t i) {
      return (before.points[i].intensity >= 20.0F && before.points[i].intensity <= 60.0F) != is_negative;
    });
  }
}

TEST(PclFilters, CropBoxKeepsWhatIsInside) {
  const FilterResult before = some_cloud(2, 2000);
  for (const bool is_negative : {false, true}) {
    PclFiltersConfig config = chain({"crop_box"});
    config.crop_box_min = {-4.0, -3.0, -2.0};
    config.crop_box_max = {5.0, 3.0, 1.0};
    config.crop_box_negative = is_negative;
    expect_kept(before, filtered(before, config), [&](std::size_t i) {
      const Eigen::Array3f p = position(before.points[i]);
      const bool is_inside = (p >= Eigen::Array3f(-4, -3, -2)).all() && (p <= Eigen::Array3f(5, 3, 1)).all();
      return is_inside != is_negative;
    });
  }
}

TEST(PclFilters, VoxelGridKeepsTheMeanOfEachCube) {
  const FilterResult before = some_cloud(3, 5000);
  for (const int least : {0, 3}) {
    PclFiltersConfig config = chain({"voxel_grid"});
    config.leaf_size = 0.7;
    config.min_points_per_voxel = least;
    const FilterResult after = filtered(before, config);
    expect_means(before, after, config.leaf_size, static_cast<std::size_t>(least));
    EXPECT_LT(after.points.size(), before.points.size());
  }
}

TEST(PclFilters, VoxelGridOfMoreCellsThanPclCountsIsTheSame) {
  FilterResult before = some_cloud(4, 3000);
  for (Point& p : before.points) {
    p.x *= 12.0F;
    p.y *= 12.0F;
    p.z *= 5.0F;
  }
  before.points.insert(before.points.end(), before.points.begin(), before.points.end());
  before.counts.total = before.counts.kept = before.points.size();
  PclFiltersConfig config = chain({"voxel_grid"});
  config.leaf_size = 0.02;  // 9600 x 9600 x 1300 cells, many more than 32 bits can number
  expect_means(before, filtered(before, config), config.leaf_size, 0);
}

TEST(PclFilters, RadiusOutlierRemovalCountsNeighbours) {
  const FilterResult before = some_cloud(5, 1500);
  PclFiltersConfig config = chain({"radius_outlier_removal"});
  config.radius_search = 0.6;
  config.min_neighbors = 3;
  const FilterResult after = filtered(before, config);
  expect_kept(before, after, [&](std::size_t i) { return distances_from(before.points, i)[2] <= 0.6F; });
  EXPECT_LT(after.points.size(), before.points.size());
}

TEST(PclFilters, StatisticalOutlierRemovalComparesMeanDistances) {
  const FilterResult before = some_cloud(6, 1500);
  PclFiltersConfig config = chain({"statistical_outlier_removal"});
  config.mean_k = 8;
  config.stddev_mul_thresh = 1.0;
  std::vector<double> means;
  double sum = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < before.points.size(); ++i) {
    const std::vector<float> distances = distances_from(before.points, i);
    double mean = 0.0;
    for (int k = 0; k < config.mean_k; ++k) mean += distances[static_cast<std::size_t>(k)] / config.mean_k;
    means.push_back(mean);
    sum += mean;
    squares += mean * mean;
  }
  const auto n = static_cast<double>(means.size());
  const double limit = sum / n + std::sqrt((squares - sum * sum / n) / (n - 1.0));
  const FilterResult after = filtered(before, config);
  expect_kept(before, after, [&](std::size_t i) { return means[i] <= limit; });
  EXPECT_LT(after.points.size(), before.points.size());
}

TEST(PclFilters, PlaneSegmentationDropsTheGround) {
  const FilterResult before = some_cloud(7, 3000);
  PclFiltersConfig config = chain({"plane_segmentation"});
  config.distance_threshold = 0.1;
  config.eps_angle = 0.1;
  const FilterResult after = filtered(before, config);
  std::size_t num_ground = 0;
  for (const Point& p : after.points) num_ground += p.z < -1.45F && p.z > -1.55F;
  EXPECT_EQ(num_ground, 0u);
  std::size_t above = 0;
  for (const Point& p : before.points) above += p.z > -1.3F || p.z < -1.7F;
  EXPECT_GE(after.points.size(), above);
  const FilterResult again = filtered(before, config);
  ASSERT_EQ(again.points.size(), after.points.size());
  for (std::size_t i = 0; i < after.points.size(); ++i) ASSERT_TRUE(is_same(after.points[i], again.points[i]));
}

TEST(PclFilters, PlanesOfAnotherDirectionStay) {
  FilterResult before = some_cloud(8, 900);
  for (Point& p : before.points) std::swap(p.x, p.z);  // the ground becomes a wall
  PclFiltersConfig config = chain({"plane_segmentation"});
  config.eps_angle = 0.1;
  const FilterResult after = filtered(before, config);
  EXPECT_GT(after.points.size(), 850u);
}

TEST(PclFilters, FiltersStandInTheOrderGiven) {
  const FilterResult before = some_cloud(9, 4000);
  PclFiltersConfig config;
  config.leaf_size = 0.5;
  config.radius_search = 0.6;
  config.min_neighbors = 4;
  config.filters = {"voxel_grid", "radius_outlier_removal"};
  const FilterResult thinned_first = filtered(before, config);
  config.filters = {"radius_outlier_removal", "voxel_grid"};
  const FilterResult cleaned_first = filtered(before, config);
  EXPECT_LT(thinned_first.points.size(), cleaned_first.points.size());
  const auto filters = make_pcl_filters(config);
  ASSERT_EQ(filters.size(), 2u);
  EXPECT_EQ(filters[0]->kind(), PclFilterKind::kRadiusOutlierRemoval);
  EXPECT_EQ(filters[1]->kind(), PclFilterKind::kVoxelGrid);
}

TEST(PclFilters, EmptyAndTinyCloudsPass) {
  const PclFiltersConfig config = chain(voxnav::base::all_words<PclFilterKind>());
  for (const std::size_t n : {0, 1, 2, 5, 21}) filtered(some_cloud(10, n), config);
  PclFiltersConfig plane = chain({"plane_segmentation", "statistical_outlier_removal"});
  EXPECT_EQ(filtered(some_cloud(11, 5), plane).points.size(), 5u);
}

TEST(PclFilters, BadParametersAreRefusedWithAReason) {
  PclFiltersConfig config = chain({"voxel_grid", "bilateral"});
  config.filter_limit_min = config.filter_limit_max;
  config.crop_box_min[1] = 60.0;
  config.axis = {0.0, 0.0, 0.0};
  try {
    make_pcl_filters(config);
    FAIL() << "accepted";
  } catch (const voxnav::base::ConfigError& error) {
    const std::string text = error.what();
    for (const char* part :
         {"filters: 'bilateral'", "pass_through", "filter_limit_min = 100", "axis y", "axis: must"}) {
      EXPECT_NE(text.find(part), std::string::npos) << part << " in " << text;
    }
  }
  config = chain({"voxel_grid"});
  config.leaf_size = 0.0;
  EXPECT_THROW(make_pcl_filters(config), voxnav::base::ConfigError);
  EXPECT_TRUE(make_pcl_filters({}).empty());
}
