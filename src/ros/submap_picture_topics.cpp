// SPDX-License-Identifier: BSD-3-Clause
#include "submap_picture_topics.hpp"

#include "voxnav_ros/messages.hpp"
#include "voxnav_ros/submap_pictures.hpp"

namespace voxnav_ros {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

constexpr std::size_t kMarkersPerTurn = 200;
constexpr std::size_t kMeshesPerTurn = 5;  // few at a time, as viewers keep a short queue of single markers
constexpr std::size_t kMinVoxelsOfChange = 10;

}  // namespace

SubmapPictures::SubmapPictures(const SubmapIntegratorConfig& config) : config_(config) {
  CubeStyle style;
  style.min_hits = config.min_marker_hits;
  style.heights = {config.color_min_m, config.color_max_m};
  const auto cubes = [this](const CubeStyle& how, const char* ns) {
    const auto draw = [this, how](const Blocks& blocks, Marker* marker) {
      const double voxel_m = evidence_->resolution_m();
      marker->scale.x = marker->scale.y = marker->scale.z = voxel_m;
      add_cubes(*evidence_, blocks, how, marker);
    };
    return std::make_unique<TiledMarkers>(blank_marker(ns, Marker::CUBE_LIST, 1.0), draw);
  };
  occupancy_.markers = cubes(style, "occupancy");
  style.is_by_submap = true;
  submaps_.markers = cubes(style, "submaps");
  const auto draw_mesh = [this, heights = style.heights](const Blocks& blocks, Marker* marker) {
    const auto limit = static_cast<std::size_t>(config_.max_mesh_triangles);
    add_mesh(*evidence_, blocks, heights, limit, marker);
  };
  mesh_.markers = std::make_unique<TiledMarkers>(blank_marker("mesh", Marker::TRIANGLE_LIST, 1.0), draw_mesh);
}

void SubmapPictures::advertise(ros::NodeHandle* nh) {
  occupancy_.topic.advertise<MarkerArray>(nh, "occupancy_markers_out");
  submaps_.topic.advertise<MarkerArray>(nh, "submap_markers_out");
  mesh_.topic.advertise<Marker>(nh, "mesh_out");
  obstacle_cloud_.topic.advertise<sensor_msgs::PointCloud2>(nh, "obstacle_cloud_out");
  slice_.topic.advertise<sensor_msgs::PointCloud2>(nh, "slice_out");
  changes_.topic.advertise<msg::SceneChanges>(nh, "changes_out");
  change_boxes_.topic.advertise<MarkerArray>(nh, "change_markers_out");
}

void SubmapPictures::mark(const MergedMap& map, const Blocks& changed) {
  tiles_.follow(map.collection().evidence(), changed);
  for (Tiled* tiled : {&occupancy_, &submaps_, &mesh_}) {
    if (!tiled->topic.is_heard()) continue;
    for (const auto& block : changed) tiled->markers->mark(tile_of(block));
  }
  for (Whole* whole : {&obstacle_cloud_, &slice_, &changes_, &change_boxes_}) whole->is_due = true;
}

/// Returns true if there is something to send. With a new subscriber all of it is due.
bool SubmapPictures::prepare(Tiled* tiled) {
  if (!tiled->topic.is_heard()) {
    tiled->markers->forget();
    return false;
  }
  if (tiled->topic.take_new()) tiled->markers->restart(tiles_);
  return tiled->markers->is_due();
}

bool SubmapPictures::Whole::take_due() {
  if (topic.take_new()) is_due = true;
  if (!is_due || !topic.is_heard()) return false;
  is_due = false;
  return true;
}

bool SubmapPictures::send_array(const std_msgs::Header& header, Tiled* tiled) {
  if (!prepare(tiled)) return false;
  MarkerArray message;
  const auto max_points = static_cast<std::size_t>(config_.max_markers);
  message.markers = tiled->markers->next(tiles_, header, max_points, kMarkersPerTurn);
  if (!message.markers.empty()) tiled->topic.publish(message);
  return true;
}

bool SubmapPictures::send_mesh(const std_msgs::Header& header) {
  if (!prepare(&mesh_)) return false;
  const auto max_points = 3 * static_cast<std::size_t>(config_.max_mesh_triangles);
  for (const Marker& marker : mesh_.markers->next(tiles_, header, max_points, kMeshesPerTurn)) {
    mesh_.topic.publish(marker);
  }
  return true;
}

bool SubmapPictures::send_changes(const MergedMap& map, const std_msgs::Header& header) {
  const bool is_list_due = changes_.take_due();
  const bool are_boxes_due = change_boxes_.take_due();
  if (!is_list_due && !are_boxes_due) return false;
  const auto max_changes = static_cast<std::size_t>(config_.max_changes);
  const msg::SceneChanges changes =
      to_msg(submap::scene_changes(map.collection().evidence(), kMinVoxelsOfChange), max_changes, header);
  if (is_list_due) changes_.topic.publish(changes);
  if (are_boxes_due) change_boxes_.topic.publish(boxes_of(changes));
  return true;
}

sensor_msgs::PointCloud2 SubmapPictures::slice_of(const MergedMap& map, const std_msgs::Header& header) const {
  const auto max_points = static_cast<std::size_t>(config_.max_cloud_points);
  const submap::SubmapEntry* newest = map.collection().newest();
  const submap::EvidenceMap& evidence = map.collection().evidence();
  if (!newest) return distance_slice(evidence, {}, 0.0, config_.slice_max_distance_m, max_points, header);
  voxnav::geometry::Pose T_W_B = newest->T_W_S;
  if (!newest->T_S_B.empty()) T_W_B = T_W_B * newest->T_S_B.back().pose;
  const auto bounds = newest->submap->known_bounds().transformed(newest->T_W_S);
  return distance_slice(evidence, bounds, T_W_B.translation().z() + config_.slice_offset_m,
                        config_.slice_max_distance_m, max_points, header);
}

bool SubmapPictures::turn(const MergedMap& map, const std_msgs::Header& header) {
  evidence_ = &map.collection().evidence();
  if (header.frame_id != frame_id_) {
    // What was sent so far stands in a frame that is no longer the map's, so it has to be sent again.
    for (Tiled* tiled : {&occupancy_, &submaps_, &mesh_}) tiled->markers->restart(tiles_);
    frame_id_ = header.frame_id;
  }
  bool has_sent = send_array(header, &occupancy_);
  has_sent |= send_array(header, &submaps_);
  has_sent |= send_mesh(header);
  has_sent |= send_changes(map, header);
  if (obstacle_cloud_.take_due()) {
    const auto max_points = static_cast<std::size_t>(config_.max_cloud_points);
    obstacle_cloud_.topic.publish(occupied_cloud(map.obstacles().grid(), max_points, header));
    has_sent = true;
  }
  if (slice_.take_due()) {
    slice_.topic.publish(slice_of(map, header));
    has_sent = true;
  }
  return has_sent;
}

}  // namespace voxnav_ros
