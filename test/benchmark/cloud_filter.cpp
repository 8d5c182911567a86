// SPDX-License-Identifier: BSD-3-Clause
// CloudFilter is measured beside the same chain of PCL filters, on an organised cloud of 256 x 1024 points in the
// Ouster layout. Both must keep the same points, otherwise the benchmark stops.
#include "voxnav/cloud/cloud_filter.hpp"

#include <benchmark/benchmark.h>
#include <pcl/PCLPointCloud2.h>
#include <pcl/conversions.h>
#include <pcl/filters/conditional_removal.h>
#include <pcl/filters/crop_box.h>
#include <pcl/filters/filter.h>
#include <pcl/point_types.h>

#include <cmath>
#include <random>

#include "raw_cloud.hpp"

namespace {

using voxnav::cloud::CloudFilter;
using voxnav::cloud::CloudFilterConfig;
using voxnav::cloud::FilterResult;
using voxnav::test::RawCloud;
using PclCloud = pcl::PointCloud<pcl::PointXYZI>;

constexpr std::uint32_t kRows = 256, kColumns = 1024;
constexpr float kMaxRange_m = 60.0F, kGhostRange_m = 20.0F, kGhostIntensity = 10.0F;

/// Returns a cloud in which a tenth of the beams have no return, a twentieth hit the vehicle, and the rest lie between
/// 1 and 80 m.
RawCloud forest_like_cloud() {
  RawCloud cloud(kRows, kColumns, 48, voxnav::test::ouster_fields());
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(0.0F, 1.0F);
  for (std::size_t i = 0; i < cloud.layout.num_points(); ++i) {
    const float kind = unit(random), azimuth = 6.2831853F * static_cast<float>(i % kColumns) / kColumns;
    const std::size_t row = i / kColumns;
    const float elevation = 0.78F * (2.0F * static_cast<float>(row) / kRows - 1.0F);
    const float range = kind < 0.05F ? 0.3F : 1.0F + 79.0F * unit(random) * unit(random);
    const float x = range * std::cos(elevation) * std::cos(azimuth),
                y = range * std::cos(elevation) * std::sin(azimuth);
    const bool is_missing = kind > 0.9F;
    const float nan = std::nanf("");
    is_missing ? cloud.set_xyz(i, nan, nan, nan) : cloud.set_xyz(i, x, y, range * std::sin(elevation));
    cloud.set(i, "intensity", 200.0F * unit(random));
    cloud.set(i, "t", static_cast<std::uint32_t>(i % kColumns * 97656));
  }
  return cloud;
}

CloudFilterConfig config() {
  CloudFilterConfig c;
  c.remove_outliers = false;  // PCL has no such filter to compare with
  c.min_range_m = 0;
  c.max_range_m = kMaxRange_m;
  c.body_radius_m = 0;
  c.use_body_box = true;
  c.body_box_min_m = {-0.5, -0.5, -0.5};
  c.body_box_max_m = {0.5, 0.5, 0.5};
  c.ghost_intensity = kGhostIntensity;
  c.ghost_range_m = kGhostRange_m;
  return c;
}

pcl::PCLPointCloud2 to_pcl(const RawCloud& cloud) {
  pcl::PCLPointCloud2 out;
  out.height = cloud.layout.height;
  out.width = cloud.layout.width;
  out.point_step = cloud.layout.point_step;
  out.row_step = out.point_step * out.width;
  for (const auto& f : cloud.layout.fields) {
    pcl::PCLPointField field;
    field.name = f.name;
    field.offset = f.offset;
    field.datatype = static_cast<std::uint8_t>(f.type);
    field.count = f.count;
    out.fields.push_back(field);
  }
  out.data.assign(cloud.bytes.begin(), cloud.bytes.end());
  return out;
}

/// Returns the PCL condition that compares x^2 + y^2 + z^2 - range^2 with 0.
pcl::TfQuadraticXYZComparison<pcl::PointXYZI>::Ptr range_is(pcl::ComparisonOps::CompareOp op, float range_m) {
  using Comparison = pcl::TfQuadraticXYZComparison<pcl::PointXYZI>;
  // Pointers of PCL 1.10 are those of Boost, so that std::make_shared is not for them.
  // NOLINTNEXTLINE(modernize-make-shared)
  return Comparison::Ptr(new Comparison(op, Eigen::Matrix3f::Identity(), Eigen::Vector3f::Zero(), -range_m * range_m));
}

void remove_unless(const pcl::ConditionBase<pcl::PointXYZI>::Ptr& condition, const PclCloud::Ptr& in, PclCloud* out) {
  pcl::ConditionalRemoval<pcl::PointXYZI> removal;
  removal.setCondition(condition);
  removal.setInputCloud(in);
  removal.filter(*out);
}

PclCloud::Ptr pcl_chain(const pcl::PCLPointCloud2& msg) {
  PclCloud::Ptr raw(new PclCloud), valid(new PclCloud), outside(new PclCloud), within(new PclCloud), kept(new PclCloud);
  pcl::fromPCLPointCloud2(msg, *raw);
  raw->is_dense = false;
  pcl::Indices indices;
  pcl::removeNaNFromPointCloud(*raw, *valid, indices);
  pcl::CropBox<pcl::PointXYZI> body;
  body.setMin(Eigen::Vector4f(-0.5F, -0.5F, -0.5F, 1.0F));
  body.setMax(Eigen::Vector4f(0.5F, 0.5F, 0.5F, 1.0F));
  body.setNegative(true);
  body.setInputCloud(valid);
  body.filter(*outside);
  pcl::ConditionAnd<pcl::PointXYZI>::Ptr near(new pcl::ConditionAnd<pcl::PointXYZI>);
  near->addComparison(range_is(pcl::ComparisonOps::LE, kMaxRange_m));
  remove_unless(near, outside, within.get());
  pcl::ConditionOr<pcl::PointXYZI>::Ptr genuine(new pcl::ConditionOr<pcl::PointXYZI>);
  using Intensity = pcl::FieldComparison<pcl::PointXYZI>;
  // NOLINTNEXTLINE(modernize-make-shared): as in range_is()
  genuine->addComparison(Intensity::Ptr(new Intensity("intensity", pcl::ComparisonOps::GE, kGhostIntensity)));
  genuine->addComparison(range_is(pcl::ComparisonOps::GE, kGhostRange_m));
  remove_unless(genuine, within, kept.get());
  return kept;
}

void filter_voxnav(benchmark::State& state) {
  const RawCloud cloud = forest_like_cloud();
  CloudFilter filter(config());
  FilterResult result;
  for (auto _ : state) filter.apply(cloud.view(), &result);
  state.counters["kept"] = static_cast<double>(result.points.size());
  state.SetItemsProcessed(state.iterations() * kRows * kColumns);
}

void filter_pcl_chain(benchmark::State& state) {
  const RawCloud cloud = forest_like_cloud();
  const pcl::PCLPointCloud2 msg = to_pcl(cloud);
  const std::size_t expected = CloudFilter(config()).apply(cloud.view()).points.size();
  std::size_t kept = 0;
  for (auto _ : state) kept = pcl_chain(msg)->size();
  if (kept != expected) state.SkipWithError("PCL and voxnav keep different points");
  state.counters["kept"] = static_cast<double>(kept);
  state.SetItemsProcessed(state.iterations() * kRows * kColumns);
}

BENCHMARK(filter_voxnav)->Unit(benchmark::kMillisecond);
BENCHMARK(filter_pcl_chain)->Unit(benchmark::kMillisecond);

}  // namespace
