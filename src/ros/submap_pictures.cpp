// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_ros/submap_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "voxnav/submap/mesh.hpp"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"

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

/// Tells for each of `total` items whether to keep it: every n-th one, so that at most `limit` are kept.
class Thinner {
 public:
  Thinner(std::size_t total, std::size_t limit) : stride_(limit > 0 ? (total + limit - 1) / limit : 0) {}
  bool keep() { return stride_ > 0 && count_++ % stride_ == 0; }

 private:
  std::size_t stride_;
  std::size_t count_ = 0;
};

geometry_msgs::Point point_of(const Vec3& p) { return voxnav_ros::to_msg(p); }

visualization_msgs::Marker box_of(const msg::SceneChange& change, const std_msgs::Header& header, std::int32_t id) {
  const bool has_appeared = change.kind == msg::SceneChange::APPEARED;
  visualization_msgs::Marker marker = blank_marker("changes", visualization_msgs::Marker::CUBE, 1.0);
  marker.header = header;
  marker.id = id;
  marker.pose.position = change.center;
  const auto middle = [](double low, double high) { return 0.5 * (low + high); };
  marker.pose.position.x = middle(change.box_min.x, change.box_max.x);
  marker.pose.position.y = middle(change.box_min.y, change.box_max.y);
  marker.pose.position.z = middle(change.box_min.z, change.box_max.z);
  constexpr double kThinnest_m = 0.1;  // rviz does not show cubes without thickness
  marker.scale.x = std::max(change.box_max.x - change.box_min.x, kThinnest_m);
  marker.scale.y = std::max(change.box_max.y - change.box_min.y, kThinnest_m);
  marker.scale.z = std::max(change.box_max.z - change.box_min.z, kThinnest_m);
  marker.color = to_msg(has_appeared ? submap::Color{60, 220, 80} : submap::Color{230, 60, 50});
  marker.color.a = 0.4f;
  return marker;
}

}  // namespace

visualization_msgs::Marker blank_marker(const char* ns, std::int32_t type, double scale_m) {
  visualization_msgs::Marker marker;
  marker.ns = ns;
  marker.type = type;
  marker.action = visualization_msgs::Marker::ADD;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = marker.scale.y = marker.scale.z = scale_m;
  marker.color.a = 1.f;
  return marker;
}

void add_cubes(const submap::EvidenceMap& evidence, const Blocks& blocks, const CubeStyle& style,
               visualization_msgs::Marker* marker) {
  for (const Index3& index : blocks) {
    const submap::EvidenceBlock* block = evidence.find(index);
    if (!block) continue;
    for (const submap::SurfaceEvidence& surface : block->points) {
      if (surface.point.hits < style.min_hits) continue;
      const Index3 voxel = voxnav::geometry::voxel_at(index, surface.offset);
      const Vec3 center = voxnav::geometry::center_of(voxel, evidence.resolution_m());
      marker->points.push_back(point_of(center));
      marker->colors.push_back(to_msg(style.is_by_submap ? submap::color_of(surface.submap_id)
                                                         : submap::color_of_height(center.z(), style.heights)));
    }
  }
}

void add_mesh(const submap::EvidenceMap& evidence, const Blocks& blocks, const submap::HeightScale& heights,
              std::size_t max_triangles, visualization_msgs::Marker* marker) {
  const submap::Mesh mesh = submap::extract_mesh(evidence, blocks, max_triangles);
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t i : triangle) {
      const Vec3 p = mesh.vertices[i].cast<double>();
      marker->points.push_back(point_of(p));
      marker->colors.push_back(to_msg(submap::color_of_height(p.z(), heights)));
    }
  }
}

sensor_msgs::PointCloud2 distance_slice(const submap::EvidenceMap& evidence, const voxnav::geometry::Aabb& bounds,
                                        double height_m, double max_distance_m, std::size_t max_points,
                                        const std_msgs::Header& header) {
  std::vector<float> rows;
  if (!bounds.empty()) {
    const Vec3 size = bounds.max - bounds.min;
    const double area_step = std::sqrt(size.x() * size.y() / static_cast<double>(std::max<std::size_t>(max_points, 1)));
    const double step = std::max(evidence.resolution_m(), area_step);
    const auto num_x = static_cast<std::int64_t>(size.x() / step) + 1;
    const auto num_y = static_cast<std::int64_t>(size.y() / step) + 1;
    for (std::int64_t i = 0; i < num_x * num_y; ++i) {
      const std::int64_t row = i / num_x, column = i % num_x;
      const Vec3 p(bounds.min.x() + static_cast<double>(column) * step,
                   bounds.min.y() + static_cast<double>(row) * step, height_m);
      if (evidence.state(p) == voxnav::containers::VoxelState::kUnknown) continue;
      add_row(p, evidence.distance_to_surface(p, max_distance_m).value_or(max_distance_m), &rows);
    }
  }
  return cloud_of(rows, header);
}

sensor_msgs::PointCloud2 occupied_cloud(const voxnav::containers::StateGrid& grid, std::size_t max_points,
                                        const std_msgs::Header& header) {
  constexpr std::uint64_t kOccupied = 0xAAAAAAAAAAAAAAAAull;
  std::size_t total = 0;
  for (const auto& item : grid.blocks()) {
    for (const std::uint64_t word : item.second.words)
      total += static_cast<std::size_t>(__builtin_popcountll(word & kOccupied));
  }
  Thinner thinner(total, max_points);
  std::vector<float> rows;
  rows.reserve(4 * std::min(total, max_points));
  for (const Index3& index : grid.sorted_block_indices()) {
    int first = 0;
    for (const std::uint64_t word : grid.find_block(index)->words) {
      for (std::uint64_t bits = word & kOccupied; bits != 0; bits &= bits - 1) {
        if (!thinner.keep()) continue;
        const Index3 voxel = voxnav::geometry::voxel_at(index, first + (__builtin_ctzll(bits) >> 1));
        const Vec3 p = voxnav::geometry::center_of(voxel, grid.resolution_m());
        add_row(p, p.z(), &rows);
      }
      first += 32;
    }
  }
  return cloud_of(rows, header);
}

msg::SceneChanges to_msg(std::vector<submap::SceneChange> changes, std::size_t max_changes,
                         const std_msgs::Header& header) {
  std::stable_sort(changes.begin(), changes.end(),
                   [](const auto& a, const auto& b) { return a.num_voxels > b.num_voxels; });
  msg::SceneChanges out;
  out.header = header;
  for (const submap::SceneChange& change : changes) {
    if (out.changes.size() >= max_changes) break;
    msg::SceneChange item;
    item.kind = change.kind == submap::SceneChange::Kind::kAppeared ? msg::SceneChange::APPEARED
                                                                    : msg::SceneChange::DISAPPEARED;
    item.submap_id = change.submap_id;
    item.num_voxels = static_cast<std::uint32_t>(change.num_voxels);
    item.center = point_of(change.center_W);
    item.box_min = point_of(change.box_W.min);
    item.box_max = point_of(change.box_W.max);
    out.changes.push_back(item);
  }
  out.num_left_out = static_cast<std::uint32_t>(changes.size() - out.changes.size());
  return out;
}

visualization_msgs::MarkerArray boxes_of(const msg::SceneChanges& changes) {
  visualization_msgs::MarkerArray out;
  out.markers.push_back(blank_marker("changes", visualization_msgs::Marker::CUBE, 1.0));
  out.markers[0].header = changes.header;
  out.markers[0].action = visualization_msgs::Marker::DELETEALL;
  for (const msg::SceneChange& change : changes.changes) {
    out.markers.push_back(box_of(change, changes.header, static_cast<std::int32_t>(out.markers.size())));
  }
  return out;
}

}  // namespace voxnav_ros
