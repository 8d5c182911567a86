// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/cloud/sweep.hpp"

#include <algorithm>
#include <utility>

#include "cloud_reader.hpp"

namespace voxnav::cloud {
namespace {

using geometry::Vec3f;

std::uint32_t largest_of(const std::vector<std::uint32_t>& offsets) {
  return offsets.empty() ? 0 : *std::max_element(offsets.begin(), offsets.end());
}

/// The direction of a point without coordinates; zero for one that has none either.
Vec3f beam_of(const std::uint8_t* point, const std::array<FieldAccess, 3>& beam) {
  const Vec3f direction(read_float(point, beam[0]), read_float(point, beam[1]), read_float(point, beam[2]));
  return direction.allFinite() ? direction : Vec3f::Zero();
}

template <class Reader>
void read_all(const RawCloudView& cloud, const CloudTimes& times, Sweep* out) {
  const Reader read(cloud.access());
  TimeReader time(cloud.access(), times);
  for (std::uint32_t r = 0; r < cloud.height(); ++r) {
    const std::uint8_t* p = cloud.row(r);
    for (std::uint32_t c = 0; c < cloud.width(); ++c, p += cloud.point_step()) {
      Vec3f position;
      read.position(p, position.data());
      if (cloud.access().beam && !position.allFinite()) {
        const Vec3f direction = beam_of(p, *cloud.access().beam);
        if (!direction.isZero(0.0F)) {
          out->open_beams.push_back(direction);
          continue;
        }
      }
      out->points.push_back(position);
      out->time_offsets_ns.push_back(time(p));
    }
  }
  out->start_ns += time.min_ns();
  // Unsigned subtraction undoes the two's complement of negative offsets.
  const auto first = static_cast<std::uint32_t>(time.min_ns());
  if (first != 0) {
    for (std::uint32_t& offset : out->time_offsets_ns) offset -= first;
  }
  out->duration_ns = largest_of(out->time_offsets_ns);
}

}  // namespace

Sweep read_sweep(const RawCloudView& cloud) {
  Sweep out;
  out.stamp_ns = out.start_ns = cloud.stamp_ns();
  if (cloud.num_points() == 0) return out;
  out.points.reserve(cloud.num_points());
  out.time_offsets_ns.reserve(cloud.num_points());
  const auto filtered = times_of_filtered(cloud);
  const CloudTimes times = filtered ? *filtered : PointTimes().judge(cloud);
  if (Float32Reader::can_read(cloud.access())) {
    read_all<Float32Reader>(cloud, times, &out);
  } else {
    read_all<AnyReader>(cloud, times, &out);
  }
  return out;
}

Sweep sweep_of(const FilterResult& filtered, base::StampNs stamp_ns, std::vector<Vec3f> open_beams) {
  Sweep out;
  out.stamp_ns = out.start_ns = stamp_ns + filtered.sweep_start_ns;
  out.points.reserve(filtered.points.size());
  out.time_offsets_ns.reserve(filtered.points.size());
  for (const Point& point : filtered.points) {
    out.points.emplace_back(point.x, point.y, point.z);
    out.time_offsets_ns.push_back(point.time_offset_ns);
  }
  out.duration_ns = largest_of(out.time_offsets_ns);
  out.open_beams = std::move(open_beams);
  return out;
}

}  // namespace voxnav::cloud
