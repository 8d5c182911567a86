// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_ros/cloud_conversions.hpp"

#include <boost/make_shared.hpp>
#include <cstring>

#include "voxnav_ros/conversions.hpp"

namespace voxnav_ros {
namespace {

using voxnav::cloud::Point;

sensor_msgs::PointField field(const char* name, std::size_t offset, std::uint8_t datatype) {
  sensor_msgs::PointField out;
  out.name = name;
  out.offset = static_cast<std::uint32_t>(offset);
  out.datatype = datatype;
  out.count = 1;
  return out;
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

voxnav::cloud::RawCloudView view_of(const sensor_msgs::PointCloud2& msg) {
  return {layout_of(msg), msg.data.data(), msg.data.size(), to_ns(msg.header.stamp)};
}

sensor_msgs::PointCloud2Ptr to_msg(const std::vector<Point>& points, const std_msgs::Header& header) {
  using sensor_msgs::PointField;
  auto msg = boost::make_shared<sensor_msgs::PointCloud2>();
  msg->header = header;
  msg->height = 1;
  msg->width = static_cast<std::uint32_t>(points.size());
  msg->fields = {field("x", offsetof(Point, x), PointField::FLOAT32),
                 field("y", offsetof(Point, y), PointField::FLOAT32),
                 field("z", offsetof(Point, z), PointField::FLOAT32),
                 field("intensity", offsetof(Point, intensity), PointField::FLOAT32),
                 field("t", offsetof(Point, time_offset_ns), PointField::UINT32)};
  msg->is_bigendian = 0;
  msg->is_dense = 1;
  msg->point_step = sizeof(Point);
  msg->row_step = static_cast<std::uint32_t>(points.size() * sizeof(Point));
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(points.data());
  msg->data.assign(bytes, bytes + points.size() * sizeof(Point));
  return msg;
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
