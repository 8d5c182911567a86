// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/cloud/timed_points.hpp"

#include "cloud_reader.hpp"

namespace voxnav::cloud {
namespace {

template <class Reader>
void read_all(const RawCloudView& cloud, TimedPoints* out) {
  const Reader read(cloud.access());
  TimeReader time(cloud.access(), cloud.stamp_ns());
  std::vector<std::uint32_t> offsets;
  for (std::uint32_t r = 0; r < cloud.height(); ++r) {
    const std::uint8_t* p = cloud.row(r);
    for (std::uint32_t c = 0; c < cloud.width(); ++c, p += cloud.point_step()) {
      geometry::Vec3f position;
      read.position(p, position.data());
      out->positions.push_back(position);
      offsets.push_back(time(p));
    }
  }
  out->sweep_start_ns += time.min_ns();
  if (!cloud.access().time) return;
  // Unsigned subtraction undoes the two's complement of negative offsets.
  const auto first = static_cast<std::uint32_t>(time.min_ns());
  for (std::uint32_t offset : offsets) out->times_s.push_back(static_cast<float>(offset - first) * 1e-9F);
}

}  // namespace

TimedPoints timed_points(const RawCloudView& cloud) {
  TimedPoints out;
  out.sweep_start_ns = cloud.stamp_ns();
  if (cloud.num_points() == 0) return out;
  out.positions.reserve(cloud.num_points());
  if (Float32Reader::can_read(cloud.access())) {
    read_all<Float32Reader>(cloud, &out);
  } else {
    read_all<AnyReader>(cloud, &out);
  }
  return out;
}

}  // namespace voxnav::cloud
