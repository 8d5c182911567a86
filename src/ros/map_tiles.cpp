// SPDX-License-Identifier: BSD-3-Clause
#include "map_tiles.hpp"

#include <algorithm>
#include <cstring>

namespace voxnav_ros {
namespace {

using voxnav::geometry::Index3;
using Marker = TiledMarkers::Marker;

/// Returns the number of points of one primitive, which must stay together.
std::size_t points_per_item(const Marker& marker) { return marker.type == Marker::TRIANGLE_LIST ? 3 : 1; }

/// Keeps every n-th primitive, so that at most `limit` points stay.
void thin(std::size_t limit, Marker* marker) {
  const std::size_t size = points_per_item(*marker);
  const std::size_t count = marker->points.size() / size;
  const std::size_t keep = std::max<std::size_t>(limit / size, 1);
  if (count <= keep) return;
  const bool has_colors = marker->colors.size() == marker->points.size();
  for (std::size_t i = 0; i < keep; ++i) {
    const std::size_t from = i * count / keep;
    for (std::size_t k = 0; k < size; ++k) {
      marker->points[size * i + k] = marker->points[size * from + k];
      if (has_colors) marker->colors[size * i + k] = marker->colors[size * from + k];
    }
  }
  marker->points.resize(keep * size);
  if (has_colors) marker->colors.resize(keep * size);
}

template <class T>
std::uint64_t add_to_sum(const std::vector<T>& values, std::uint64_t sum) {
  for (const T& value : values) {
    std::uint64_t words[sizeof(T) / 8];
    std::memcpy(words, &value, sizeof(words));
    for (const std::uint64_t word : words) {
      sum = (sum ^ word) * 0xBF58476D1CE4E5B9ull;
      sum ^= sum >> 29;
    }
  }
  return sum;
}

/// Computes a checksum of the visible parts of a marker. It is never 0, which stands for no marker.
std::uint64_t sum_of(const Marker& marker) {
  return add_to_sum(marker.colors, add_to_sum(marker.points, 0x9E3779B97F4A7C15ull)) | 1u;
}

}  // namespace

Tile tile_of(const Index3& block) { return {block.x >> 1, block.y >> 1}; }

void MapTiles::follow(const voxnav::submap::EvidenceMap& evidence, const std::vector<Index3>& changed) {
  for (const Index3& block : changed) {
    const Tile tile = tile_of(block);
    if (evidence.find(block)) {
      tiles_[tile].insert(block);
      continue;
    }
    const auto found = tiles_.find(tile);
    if (found == tiles_.end()) continue;
    found->second.erase(block);
    if (found->second.empty()) tiles_.erase(found);
  }
}

const std::set<Index3>& MapTiles::blocks_of(const Tile& tile) const {
  static const std::set<Index3> none;
  const auto found = tiles_.find(tile);
  return found == tiles_.end() ? none : found->second;
}

void TiledMarkers::restart(const MapTiles& tiles) {
  forget();
  is_restarting_ = true;
  for (const auto& item : tiles.all()) due_.insert(item.first);
}

void TiledMarkers::forget() {
  due_.clear();
  shown_.clear();
}

std::vector<Marker> TiledMarkers::next(const MapTiles& tiles, const std_msgs::Header& header, std::size_t max_points,
                                       std::size_t max_markers) {
  std::vector<Marker> out;
  std::size_t num_points = 0;
  blank_.header = header;
  if (is_restarting_ && !due_.empty()) {
    out.push_back(blank_);
    out.back().action = Marker::DELETEALL;
    is_restarting_ = false;
  }
  while (!due_.empty() && out.size() < max_markers && num_points < max_points) {
    const Tile tile = *due_.begin();
    const auto& blocks = tiles.blocks_of(tile);
    Marker marker = blank_;
    draw_({blocks.begin(), blocks.end()}, &marker);
    thin(max_points, &marker);
    if (num_points > 0 && num_points + marker.points.size() > max_points) break;  // the tile is drawn again next turn
    due_.erase(due_.begin());
    const std::uint64_t sum = marker.points.empty() ? 0 : sum_of(marker);
    auto shown = shown_.find(tile);
    if (sum == (shown == shown_.end() ? 0 : shown->second.sum)) continue;
    if (shown == shown_.end()) shown = shown_.insert({tile, {next_id_++, 0}}).first;
    marker.id = shown->second.id;
    shown->second.sum = sum;
    // A tile without points is deleted, because rviz rejects a list without points.
    marker.action = sum == 0 ? Marker::DELETE : Marker::ADD;
    if (sum == 0) shown_.erase(shown);
    num_points += marker.points.size();
    out.push_back(std::move(marker));
  }
  return out;
}

}  // namespace voxnav_ros
