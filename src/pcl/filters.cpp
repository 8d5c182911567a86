// SPDX-License-Identifier: BSD-3-Clause
/// The only source that sees PCL's filters, whose headers take long to compile.
#include <pcl/common/common.h>
#include <pcl/console/print.h>
#include <pcl/filters/crop_box.h>
#include <pcl/filters/passthrough.h>
#include <pcl/filters/radius_outlier_removal.h>
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_types.h>
#include <pcl/segmentation/sac_segmentation.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "voxnav/cloud/pcl_filters.hpp"

namespace voxnav::cloud {
namespace {

/// PCL has this type compiled; of it `curvature` carries the time of a point, so that a mean has one too.
using PclPoint = pcl::PointXYZINormal;
using PclCloud = pcl::PointCloud<PclPoint>;

PclCloud::Ptr to_pcl(const std::vector<Point>& points) {
  PclCloud::Ptr cloud(new PclCloud);
  cloud->resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    PclPoint& out = (*cloud)[i];
    out.x = points[i].x;
    out.y = points[i].y;
    out.z = points[i].z;
    out.intensity = points[i].intensity;
    out.curvature = static_cast<float>(points[i].time_offset_ns);
  }
  return cloud;
}

/// A filter that chooses among the points: those keep all that is known of them.
class Selection : public PclFilter {
 public:
  void apply(FilterResult* result) override {
    std::vector<Point>& points = result->points;
    if (points.size() < least_points()) return;
    const std::vector<int> kept = select(to_pcl(points));
    std::size_t end = 0;
    for (const int i : kept) points[end++] = points[static_cast<std::size_t>(i)];
    result->counts.pcl += points.size() - end;
    result->counts.kept -= points.size() - end;
    points.resize(end);
  }

 protected:
  /// PCL reads beyond the end of smaller clouds, or complains on the terminal; they are left as they are.
  virtual std::size_t least_points() const { return 1; }
  /// Indices in ascending order.
  virtual std::vector<int> select(const PclCloud::ConstPtr& cloud) = 0;
};

/// The filters that PCL derives from FilterIndices.
template <class Filter, PclFilterKind kKind>
class IndexFilter : public Selection {
 public:
  IndexFilter(const Filter& filter, std::size_t least_points) : filter_(filter), least_points_(least_points) {}
  PclFilterKind kind() const override { return kKind; }

 protected:
  std::size_t least_points() const override { return least_points_; }
  std::vector<int> select(const PclCloud::ConstPtr& cloud) override {
    std::vector<int> kept;
    filter_.setInputCloud(cloud);
    filter_.filter(kept);
    return kept;
  }

 private:
  Filter filter_;
  std::size_t least_points_;
};

/// What remains beside the largest plane; all, where there is none.
class PlaneRemoval : public Selection {
 public:
  explicit PlaneRemoval(const PclFiltersConfig& config) {
    sac_.setModelType(pcl::SACMODEL_PERPENDICULAR_PLANE);
    sac_.setMethodType(pcl::SAC_RANSAC);
    sac_.setAxis(Eigen::Vector3d(config.axis.data()).normalized().cast<float>());
    sac_.setEpsAngle(config.eps_angle);
    sac_.setDistanceThreshold(config.distance_threshold);
    sac_.setMaxIterations(config.max_iterations);
    sac_.setOptimizeCoefficients(true);
  }
  PclFilterKind kind() const override { return PclFilterKind::kPlaneSegmentation; }

 protected:
  std::size_t least_points() const override { return 10; }
  std::vector<int> select(const PclCloud::ConstPtr& cloud) override {
    pcl::PointIndices plane;
    pcl::ModelCoefficients coefficients;
    sac_.setInputCloud(cloud);
    // A cloud without such a plane is nothing wrong, and PCL would say so on the terminal for each one.
    const auto level = pcl::console::getVerbosityLevel();
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
    sac_.segment(plane, coefficients);
    pcl::console::setVerbosityLevel(level);
    std::vector<char> is_plane(cloud->size(), 0);
    for (const int i : plane.indices) is_plane[static_cast<std::size_t>(i)] = 1;
    std::vector<int> kept;
    for (std::size_t i = 0; i < is_plane.size(); ++i) {
      if (!is_plane[i]) kept.push_back(static_cast<int>(i));
    }
    return kept;
  }

 private:
  pcl::SACSegmentation<PclPoint> sac_{false};  // false: the same random numbers each time
};

class VoxelGrid : public PclFilter {
 public:
  explicit VoxelGrid(const PclFiltersConfig& config) : inverse_leaf_(1.0F / static_cast<float>(config.leaf_size)) {
    const auto leaf = static_cast<float>(config.leaf_size);
    grid_.setLeafSize(leaf, leaf, leaf);
    grid_.setMinimumPointsNumberPerVoxel(static_cast<unsigned>(config.min_points_per_voxel));
  }
  PclFilterKind kind() const override { return PclFilterKind::kVoxelGrid; }

  void apply(FilterResult* result) override {
    if (result->points.empty()) return;
    const std::size_t before = result->points.size();
    const PclCloud::Ptr cloud = to_pcl(result->points);
    result->points.clear();
    downsample(cloud, &result->points);
    result->counts.pcl += before - result->points.size();
    result->counts.kept -= before - result->points.size();
  }

 private:
  using Cells = Eigen::Array3d;

  Cells cell_of(const Eigen::Vector4f& p) const { return (p.head<3>() * inverse_leaf_).array().floor().cast<double>(); }

  /// PCL numbers the cells of the cloud's bounding box with 32 bits and gives up where these are not enough. Such a
  /// cloud is cut in two between cells, which changes no mean.
  void downsample(const PclCloud::ConstPtr& cloud, std::vector<Point>* out) {
    constexpr double kMostCells = 1 << 30;
    Eigen::Vector4f low, high;
    pcl::getMinMax3D(*cloud, low, high);
    const Cells first = cell_of(low), sides = cell_of(high) - first + 1.0;
    if (sides.prod() > kMostCells) {
      int axis = 0;
      sides.maxCoeff(&axis);
      const double middle = first[axis] + std::floor(0.5 * sides[axis]);
      PclCloud::Ptr half[2] = {PclCloud().makeShared(), PclCloud().makeShared()};
      for (const PclPoint& p : *cloud) half[cell_of(p.getVector4fMap())[axis] < middle ? 0 : 1]->push_back(p);
      for (const PclCloud::Ptr& part : half) downsample(part, out);
      return;
    }
    PclCloud means;
    grid_.setInputCloud(cloud);
    grid_.filter(means);
    for (const PclPoint& p : means) {
      Point point{};
      point.x = p.x;
      point.y = p.y;
      point.z = p.z;
      point.intensity = p.intensity;
      point.time_offset_ns = static_cast<std::uint32_t>(std::llround(p.curvature));
      out->push_back(point);
    }
  }

  pcl::VoxelGrid<PclPoint> grid_;
  float inverse_leaf_;
};

std::unique_ptr<PclFilter> pass_through(const PclFiltersConfig& config) {
  pcl::PassThrough<PclPoint> filter;
  filter.setFilterFieldName(base::word_of(config.filter_field_name));
  filter.setFilterLimits(static_cast<float>(config.filter_limit_min), static_cast<float>(config.filter_limit_max));
  filter.setNegative(config.filter_limit_negative);
  return std::make_unique<IndexFilter<pcl::PassThrough<PclPoint>, PclFilterKind::kPassThrough>>(filter, 1);
}

std::unique_ptr<PclFilter> crop_box(const PclFiltersConfig& config) {
  const auto corner = [](const std::array<double, 3>& p) {
    return Eigen::Vector4f(static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]), 1.0F);
  };
  pcl::CropBox<PclPoint> filter;
  filter.setMin(corner(config.crop_box_min));
  filter.setMax(corner(config.crop_box_max));
  filter.setNegative(config.crop_box_negative);
  return std::make_unique<IndexFilter<pcl::CropBox<PclPoint>, PclFilterKind::kCropBox>>(filter, 1);
}

std::unique_ptr<PclFilter> radius_outlier_removal(const PclFiltersConfig& config) {
  pcl::RadiusOutlierRemoval<PclPoint> filter;
  filter.setRadiusSearch(config.radius_search);
  filter.setMinNeighborsInRadius(config.min_neighbors);
  using Kind = IndexFilter<pcl::RadiusOutlierRemoval<PclPoint>, PclFilterKind::kRadiusOutlierRemoval>;
  return std::make_unique<Kind>(filter, 1);
}

std::unique_ptr<PclFilter> statistical_outlier_removal(const PclFiltersConfig& config) {
  pcl::StatisticalOutlierRemoval<PclPoint> filter;
  filter.setMeanK(config.mean_k);
  filter.setStddevMulThresh(config.stddev_mul_thresh);
  using Kind = IndexFilter<pcl::StatisticalOutlierRemoval<PclPoint>, PclFilterKind::kStatisticalOutlierRemoval>;
  return std::make_unique<Kind>(filter, static_cast<std::size_t>(config.mean_k) + 2);
}

std::unique_ptr<PclFilter> make(PclFilterKind kind, const PclFiltersConfig& config) {
  switch (kind) {
    case PclFilterKind::kPassThrough:
      return pass_through(config);
    case PclFilterKind::kCropBox:
      return crop_box(config);
    case PclFilterKind::kVoxelGrid:
      return std::make_unique<VoxelGrid>(config);
    case PclFilterKind::kRadiusOutlierRemoval:
      return radius_outlier_removal(config);
    case PclFilterKind::kStatisticalOutlierRemoval:
      return statistical_outlier_removal(config);
    case PclFilterKind::kPlaneSegmentation:
      return std::make_unique<PlaneRemoval>(config);
  }
  throw std::logic_error("unknown filter of PCL");
}

}  // namespace
}  // namespace voxnav::cloud

/// Called by make_pcl_filters() once the library is loaded.
extern "C" voxnav::cloud::PclFilter* voxnav_make_pcl_filter(voxnav::cloud::PclFilterKind kind,
                                                            const voxnav::cloud::PclFiltersConfig& config) {
  return voxnav::cloud::make(kind, config).release();
}
