// SPDX-License-Identifier: BSD-3-Clause
// Each filter of PCL that can stand behind the CloudFilter, beside the CloudFilter itself, on one cloud of 128 x 1024
// points of a hall with boxes.
#include "voxnav/cloud/pcl_filters.hpp"

#include <benchmark/benchmark.h>

#include <cmath>

#include "raw_cloud.hpp"
#include "room_world.hpp"

namespace {

using namespace voxnav::cloud;  // NOLINT: benchmark
using voxnav::geometry::Vec3;

constexpr std::uint32_t kRows = 128, kColumns = 1024;
constexpr double kPi = 3.14159265358979323846;

voxnav::test::RawCloud hall() {
  const auto world = voxnav::test::RoomWorld::hall();
  voxnav::test::RawCloud cloud(kRows, kColumns, 48, voxnav::test::ouster_fields());
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 0.02);
  for (std::size_t i = 0; i < cloud.layout.num_points(); ++i) {
    const double azimuth = 2.0 * kPi * static_cast<double>(i % kColumns) / kColumns + 1e-3;
    const std::size_t row = i / kColumns;
    const double elevation = 0.25 * kPi * (1.0 - 2.0 * static_cast<double>(row) / kRows);
    const Vec3 d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
    const Vec3 p = d * (world.range(Vec3::Zero(), d) + noise(random));
    cloud.set_xyz(i, static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
    cloud.set(i, "intensity", 100.0F);
    cloud.set(i, "t", static_cast<std::uint32_t>(i % kColumns * 97656));
  }
  return cloud;
}

void fast_filter(benchmark::State& state) {
  const auto cloud = hall();
  CloudFilter filter{CloudFilterConfig()};
  FilterResult result;
  for (auto _ : state) filter.apply(cloud.view(), &result);
  state.counters["kept"] = static_cast<double>(result.points.size());
}

void pcl_filter(benchmark::State& state) {
  const auto cloud = hall();
  const FilterResult before = CloudFilter{CloudFilterConfig()}.apply(cloud.view());
  PclFiltersConfig config;
  config.filters = {voxnav::base::word_of(static_cast<PclFilterKind>(state.range(0)))};
  const auto filters = make_pcl_filters(config);
  FilterResult result;
  for (auto _ : state) {
    state.PauseTiming();
    result = before;
    state.ResumeTiming();
    filters[0]->apply(&result);
  }
  state.SetLabel(config.filters[0]);
  state.counters["kept"] = static_cast<double>(result.points.size());
}

BENCHMARK(fast_filter)->Unit(benchmark::kMillisecond);
BENCHMARK(pcl_filter)->DenseRange(0, 5)->Unit(benchmark::kMillisecond);

}  // namespace
