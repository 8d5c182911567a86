// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_ros/cloud_conversions.hpp"

#include <boost/make_shared.hpp>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "voxnav_ros/conversions.hpp"

namespace voxnav_ros {
namespace {

using voxnav::cloud::Point;
using voxnav::geometry::Vec3f;

sensor_msgs::PointField field(const char* name, std::size_t offset, std::uint8_t datatype) {
  sensor_msgs::PointField out;
  out.name = name;
  out.offset = static_cast<std::uint32_t>(offset);
  out.datatype = datatype;
  out.count = 1;
  return out;
}

/// A row of a cloud with open beams. A row of a point has no beam direction, a row of a beam has no coordinates.
struct PointOrBeam {
  Point point;
  float beam[3];
};
static_assert(sizeof(PointOrBeam) == sizeof(Point) + 3 * sizeof(float));

/// Makes header and fields of a cloud whose rows begin with a Point, without its bytes.
sensor_msgs::PointCloud2Ptr empty_cloud_msg(std::size_t num_rows, std::size_t point_step,
                                            const std_msgs::Header& header) {
  using sensor_msgs::PointField;
  auto msg = boost::make_shared<sensor_msgs::PointCloud2>();
  msg->header = header;
  msg->height = 1;
  msg->width = static_cast<std::uint32_t>(num_rows);
  msg->fields = {field("x", offsetof(Point, x), PointField::FLOAT32),
                 field("y", offsetof(Point, y), PointField::FLOAT32),
                 field("z", offsetof(Point, z), PointField::FLOAT32),
                 field("intensity", offsetof(Point, intensity), PointField::FLOAT32),
                 field("t", offsetof(Point, time_offset_ns), PointField::UINT32)};
  msg->is_bigendian = 0;
  msg->is_dense = 1;
  msg->point_step = static_cast<std::uint32_t>(point_step);
  msg->row_step = static_cast<std::uint32_t>(num_rows * point_step);
  return msg;
}

}  // namespace

voxnav::cloud::CloudLayout layout_of(const sensor_msgs::PointCloud2& msg) {
  voxnav::cloud::CloudLayout layout;
  layout.height = msg.height;
  layout.width = msg.width;
  layout.point_step = msg.point_step;
  layout.row_step = msg.row_step;
  layout.is_big_endian = msg.is_bigendian != 0;
  for (const sensor_msgs::PointField& f : msg.fields) {
    layout.fields.push_back({f.name, f.offset, static_cast<voxnav::cloud::FieldType>(f.datatype), f.count});
  }
  return layout;
}

void set_layout(const voxnav::cloud::CloudLayout& layout, sensor_msgs::PointCloud2* msg) {
  msg->height = layout.height;
  msg->width = layout.width;
  msg->point_step = layout.point_step;
  msg->row_step = layout.row_step > 0 ? layout.row_step : layout.width * layout.point_step;
  msg->is_bigendian = layout.is_big_endian ? 1 : 0;
  msg->fields.clear();
  for (const voxnav::cloud::CloudField& f : layout.fields)
    msg->fields.push_back(field(f.name.c_str(), f.offset, static_cast<std::uint8_t>(f.type)));
}

voxnav::cloud::RawCloudView view_of(const sensor_msgs::PointCloud2& msg) {
  return {layout_of(msg), msg.data.data(), msg.data.size(), to_ns(msg.header.stamp)};
}

sensor_msgs::PointCloud2Ptr to_msg(const std::vector<Point>& points, const std_msgs::Header& header) {
  auto msg = empty_cloud_msg(points.size(), sizeof(Point), header);
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(points.data());
  msg->data.assign(bytes, bytes + points.size() * sizeof(Point));
  return msg;
}

sensor_msgs::PointCloud2Ptr to_msg(const std::vector<Point>& points, const std::vector<Vec3f>& open_beams,
                                   const std_msgs::Header& header) {
  const std::size_t num_rows = points.size() + open_beams.size();
  auto msg = empty_cloud_msg(num_rows, sizeof(PointOrBeam), header);
  for (const char* name : {"beam_x", "beam_y", "beam_z"}) {
    msg->fields.push_back(
        field(name, sizeof(Point) + (msg->fields.size() - 5) * sizeof(float), sensor_msgs::PointField::FLOAT32));
  }
  msg->is_dense = open_beams.empty();
  msg->data.resize(num_rows * sizeof(PointOrBeam));
  std::uint8_t* row = msg->data.data();
  const auto write = [&row](const PointOrBeam& value) {
    std::memcpy(row, &value, sizeof(value));
    row += sizeof(value);
  };
  for (const Point& point : points) write({point, {0.0F, 0.0F, 0.0F}});
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  for (const Vec3f& beam : open_beams) write({{kNaN, kNaN, kNaN, 0.0F, 0}, {beam.x(), beam.y(), beam.z()}});
  return msg;
}

voxnav::cloud::Sweep sweep_of(const sensor_msgs::PointCloud2& msg) {
  const std::string frame = frame_name(msg.header.frame_id);
  if (frame.empty()) throw std::invalid_argument("frame_id is empty");
  voxnav::cloud::Sweep sweep = voxnav::cloud::read_sweep(view_of(msg));
  sweep.frame = frame;
  return sweep;
}

sensor_msgs::PointCloud2 xyz_cloud_of(const voxnav::geometry::PointsView& points, const std_msgs::Header& header) {
  sensor_msgs::PointCloud2 msg;
  msg.header = header;
  msg.height = 1;
  msg.width = static_cast<std::uint32_t>(points.size());
  msg.point_step = 3 * sizeof(float);
  msg.row_step = msg.width * msg.point_step;
  msg.is_dense = true;
  const char* names[] = {"x", "y", "z"};
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    sensor_msgs::PointField field;
    field.name = names[axis];
    field.offset = axis * sizeof(float);
    field.datatype = sensor_msgs::PointField::FLOAT32;
    field.count = 1;
    msg.fields.push_back(field);
  }
  msg.data.resize(points.size() * msg.point_step);
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::memcpy(&msg.data[i * 3 * sizeof(float)], points[i].data(), 3 * sizeof(float));
  }
  return msg;
}

}  // namespace voxnav_ros
