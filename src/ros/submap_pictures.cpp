// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_ros/submap_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "voxnav/submap/mesh.hpp"
#include "voxnav_ros/conversions.hpp"

namespace voxnav_ros {
namespace {

using voxnav::geometry::Index3;
using voxnav::geometry::Vec3;
namespace submap = voxnav::submap;

std_msgs::ColorRGBA to_msg(const submap::Color& color) {
  std_msgs::ColorRGBA out;
  out.r = static_cast<float>(color[0]) / 255.f;
  out.g = static_cast<float>(color[1]) / 255.f;
  out.b = static_cast<float>(color[2]) / 255.f;
  out.a = 1.f;
  return out;
}

visualization_msgs::Marker new_marker(const std_msgs::Header& header, const char* ns, std::uint32_t id, int type) {
  visualization_msgs::Marker marker;
  marker.header = header;
  marker.ns = ns;
  marker.id = static_cast<std::int32_t>(id);
  marker.type = type;
  marker.action = visualization_msgs::Marker::ADD;
  marker.pose.orientation.w = 1.0;
  marker.color = to_msg(submap::color_of(id));
  return marker;
}

sensor_msgs::PointField field_of(const char* name, std::uint32_t offset) {
  sensor_msgs::PointField field;
  field.name = name;
  field.offset = offset;
  field.datatype = sensor_msgs::PointField::FLOAT32;
  field.count = 1;
  return field;
}

sensor_msgs::PointCloud2 cloud_of(const std::vector<float>& rows, const std_msgs::Header& header) {
  constexpr std::uint32_t kStep = 4 * sizeof(float);
  sensor_msgs::PointCloud2 cloud;
  cloud.header = header;
  cloud.fields = {field_of("x", 0), field_of("y", 4), field_of("z", 8), field_of("intensity", 12)};
  cloud.height = 1;
  cloud.width = static_cast<std::uint32_t>(rows.size() / 4);
  cloud.point_step = kStep;
  cloud.row_step = kStep * cloud.width;
  cloud.is_dense = true;
  cloud.data.resize(rows.size() * sizeof(float));
  if (!rows.empty()) std::memcpy(cloud.data.data(), rows.data(), cloud.data.size());
  return cloud;
}

void add_row(const Vec3& p, double intensity, std::vector<float>* rows) {
  for (int k = 0; k < 3; ++k) rows->push_back(static_cast<float>(p[k]));
  rows->push_back(static_cast<float>(intensity));
}

/// Keeps every n-th of what it is asked about, so that at most `limit` of `total` pass.
class Thinner {
 public:
  Thinner(std::size_t total, std::size_t limit) : stride_(limit > 0 ? (total + limit - 1) / limit : 0) {}
  bool keep() { return stride_ > 0 && count_++ % stride_ == 0; }

 private:
  std::size_t stride_;
  std::size_t count_ = 0;
};

std::vector<Index3> sorted_blocks(const submap::EvidenceMap& evidence, std::size_t* num_leaves) {
  std::vector<Index3> out;
  *num_leaves = 0;
  for (const auto& item : evidence.blocks()) {
    out.push_back(item.first);
    *num_leaves += item.second.leaves.size();
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

visualization_msgs::MarkerArray occupancy_markers(const submap::SubmapCollection& collection,
                                                  const std_msgs::Header& header, std::size_t max_cubes) {
  const submap::EvidenceMap& evidence = collection.evidence();
  std::size_t total = 0;
  const std::vector<Index3> blocks = sorted_blocks(evidence, &total);
  Thinner thinner(total, max_cubes);
  std::map<std::uint32_t, visualization_msgs::Marker> markers;
  for (const Index3& index : blocks) {
    for (const submap::EvidenceLeaf& leaf : evidence.find(index)->leaves) {
      if (!thinner.keep()) continue;
      auto found = markers.find(leaf.submap_id);
      if (found == markers.end()) {
        const auto type = visualization_msgs::Marker::CUBE_LIST;
        found = markers.emplace(leaf.submap_id, new_marker(header, "occupancy", leaf.submap_id, type)).first;
        found->second.scale.x = found->second.scale.y = found->second.scale.z = evidence.resolution_m();
      }
      const Index3 voxel = voxnav::geometry::voxel_at(index, leaf.offset);
      found->second.points.push_back(voxnav_ros::to_msg(voxnav::geometry::center_of(voxel, evidence.resolution_m())));
    }
  }
  visualization_msgs::MarkerArray out;
  visualization_msgs::Marker erase = new_marker(header, "occupancy", 0, visualization_msgs::Marker::CUBE_LIST);
  erase.action = visualization_msgs::Marker::DELETEALL;
  out.markers.push_back(erase);
  for (auto& item : markers) out.markers.push_back(std::move(item.second));
  return out;
}

visualization_msgs::Marker mesh_marker(const submap::SubmapEntry& entry, const std_msgs::Header& header,
                                       std::size_t max_triangles) {
  visualization_msgs::Marker marker = new_marker(header, "mesh", entry.id, visualization_msgs::Marker::TRIANGLE_LIST);
  marker.pose = voxnav_ros::to_msg(entry.T_W_S);
  marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
  const submap::Mesh mesh = submap::extract_mesh(*entry.submap, max_triangles);
  marker.points.reserve(3 * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t i : triangle)
      marker.points.push_back(voxnav_ros::to_msg(Vec3(mesh.vertices[i].cast<double>())));
  }
  // rviz rejects a triangle list without points.
  if (marker.points.empty()) marker.action = visualization_msgs::Marker::DELETE;
  return marker;
}

sensor_msgs::PointCloud2 distance_slice(const submap::EvidenceMap& evidence, const voxnav::geometry::Aabb& bounds,
                                        double height_m, double max_distance_m, std::size_t max_points,
                                        const std_msgs::Header& header) {
  std::vector<float> rows;
  if (!bounds.empty()) {
    const Vec3 size = bounds.max - bounds.min;
    const double area_step = std::sqrt(size.x() * size.y() / static_cast<double>(std::max<std::size_t>(max_points, 1)));
    const double step = std::max(evidence.resolution_m(), area_step);
    for (double y = bounds.min.y(); y <= bounds.max.y(); y += step) {
      for (double x = bounds.min.x(); x <= bounds.max.x(); x += step) {
        const Vec3 p(x, y, height_m);
        if (evidence.state(p) == voxnav::containers::State::kUnknown) continue;
        add_row(p, evidence.distance_to_surface(p, max_distance_m).value_or(max_distance_m), &rows);
      }
    }
  }
  return cloud_of(rows, header);
}

sensor_msgs::PointCloud2 occupied_cloud(const voxnav::containers::StateGrid& grid, std::size_t max_points,
                                        const std_msgs::Header& header) {
  std::vector<Vec3> centers;
  for (const Index3& index : grid.sorted_block_indices()) {
    const voxnav::containers::StateBlock* block = grid.find_block(index);
    for (int offset = 0; offset < voxnav::geometry::kBlockVolume; ++offset) {
      if (block->get(offset) != voxnav::containers::State::kOccupied) continue;
      centers.push_back(voxnav::geometry::center_of(voxnav::geometry::voxel_at(index, offset), grid.resolution_m()));
    }
  }
  Thinner thinner(centers.size(), max_points);
  std::vector<float> rows;
  for (const Vec3& p : centers) {
    if (thinner.keep()) add_row(p, p.z(), &rows);
  }
  return cloud_of(rows, header);
}

}  // namespace voxnav_ros
