// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"
#include "voxnav/cloud/cloud_filter.hpp"

namespace voxnav::cloud {

/// Filters of the Point Cloud Library that can stand behind the CloudFilter.
enum class PclFilterKind {
  kPassThrough,                ///< pcl::PassThrough
  kCropBox,                    ///< pcl::CropBox
  kVoxelGrid,                  ///< pcl::VoxelGrid
  kRadiusOutlierRemoval,       ///< pcl::RadiusOutlierRemoval
  kStatisticalOutlierRemoval,  ///< pcl::StatisticalOutlierRemoval
  kPlaneSegmentation,          ///< pcl::SACSegmentation; the points of the plane are dropped
};
constexpr auto words_of(PclFilterKind) {
  return std::array{
      "pass_through",      "crop_box", "voxel_grid", "radius_outlier_removal", "statistical_outlier_removal",
      "plane_segmentation"};
}

/// What pcl::PassThrough looks at.
enum class PclField { kX, kY, kZ, kIntensity };
constexpr auto words_of(PclField) { return std::array{"x", "y", "z", "intensity"}; }

/// Which filters of PCL a cloud goes through after the CloudFilter, and their parameters, which have the names that PCL
/// gives them. Positions are in the sensor frame L.
struct PclFiltersConfig {
  std::vector<std::string> filters;
  PclField filter_field_name = PclField::kZ;
  double filter_limit_min = -100.0;
  double filter_limit_max = 100.0;
  bool filter_limit_negative = false;
  std::array<double, 3> crop_box_min{-50.0, -50.0, -50.0};
  std::array<double, 3> crop_box_max{50.0, 50.0, 50.0};
  bool crop_box_negative = false;
  double leaf_size = 0.1;
  int min_points_per_voxel = 0;
  double radius_search = 0.5;
  int min_neighbors = 2;
  int mean_k = 20;
  double stddev_mul_thresh = 2.0;
  double distance_threshold = 0.2;
  int max_iterations = 100;
  std::array<double, 3> axis{0.0, 0.0, 1.0};
  double eps_angle = 0.25;

  template <class V>
  static void fields(V&& v) {
    using C = PclFiltersConfig;
    v("filters", &C::filters, base::any(), "",
      "in this order: pass_through, crop_box, voxel_grid, radius_outlier_removal, statistical_outlier_removal, "
      "plane_segmentation; none by default, since most of them take many times the time of the fast filter");
    v("filter_field_name", &C::filter_field_name, base::one_of<PclField>(), "", "pass_through: what is compared");
    v("filter_limit_min", &C::filter_limit_min, base::in(-1e6, 1e6), "", "pass_through: smaller values are dropped");
    v("filter_limit_max", &C::filter_limit_max, base::in(-1e6, 1e6), "", "pass_through: larger values are dropped");
    v("filter_limit_negative", &C::filter_limit_negative, base::any(), "",
      "pass_through: drop what is inside the limits instead");
    v("crop_box_min", &C::crop_box_min, base::in(-1e4, 1e4), "m", "crop_box: lower corner");
    v("crop_box_max", &C::crop_box_max, base::in(-1e4, 1e4), "m", "crop_box: upper corner");
    v("crop_box_negative", &C::crop_box_negative, base::any(), "", "crop_box: drop what is inside instead");
    v("leaf_size", &C::leaf_size, base::in(0.01, 10), "m",
      "voxel_grid: the points of a cube of this edge become one, their mean in place, intensity and time");
    v("min_points_per_voxel", &C::min_points_per_voxel, base::in(0, 1000), "",
      "voxel_grid: cubes with fewer are dropped");
    v("radius_search", &C::radius_search, base::in(0.01, 10), "m",
      "radius_outlier_removal: where neighbours are counted");
    v("min_neighbors", &C::min_neighbors, base::in(1, 1000), "",
      "radius_outlier_removal: points with fewer are dropped");
    v("mean_k", &C::mean_k, base::in(1, 200), "",
      "statistical_outlier_removal: neighbours whose mean distance is taken");
    v("stddev_mul_thresh", &C::stddev_mul_thresh, base::in(0, 100), "",
      "statistical_outlier_removal: points whose mean distance is so many deviations above the mean are dropped");
    v("distance_threshold", &C::distance_threshold, base::in(0.001, 10), "m",
      "plane_segmentation: points so near the plane are dropped");
    v("max_iterations", &C::max_iterations, base::in(1, 10000), "", "plane_segmentation: planes that are tried");
    v("axis", &C::axis, base::in(-1, 1), "", "plane_segmentation: direction that the normal of the plane has");
    v("eps_angle", &C::eps_angle, base::in(0.001, 1.57), "rad", "plane_segmentation: how far it may be off");
  }
  std::vector<std::string> problems() const;
  /// The chain; all of them known once problems() is empty.
  std::vector<PclFilterKind> kinds() const;
};

/// One filter of PCL. Not thread-safe; deterministic.
class PclFilter {
 public:
  virtual ~PclFilter() = default;
  virtual PclFilterKind kind() const = 0;
  /// Filters the points that are still kept. What it drops, or merges with others, is counted as `pcl`.
  virtual void apply(FilterResult* result) = 0;
};

/// The chain of a configuration, in its order. PCL is loaded only when there is one.
/// @throws base::ConfigError
/// @throws std::runtime_error when voxnav was built without PCL
std::vector<std::unique_ptr<PclFilter>> make_pcl_filters(const PclFiltersConfig& config);

}  // namespace voxnav::cloud
