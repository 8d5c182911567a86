// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <visualization_msgs/Marker.h>

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "voxnav/submap/evidence_map.hpp"

namespace voxnav_ros {

/// A column of 2 x 2 blocks over all heights, the unit in which markers are drawn, sent and replaced.
using Tile = std::pair<std::int32_t, std::int32_t>;
Tile tile_of(const voxnav::geometry::Index3& block);

/// The known blocks of each tile.
class MapTiles {
 public:
  /// Updates the tiles with blocks that changed, were added or were removed.
  void follow(const voxnav::submap::EvidenceMap& evidence, const std::vector<voxnav::geometry::Index3>& changed);
  /// Returns the known blocks of a tile, sorted; empty if there are none.
  const std::set<voxnav::geometry::Index3>& blocks_of(const Tile& tile) const;
  const std::map<Tile, std::set<voxnav::geometry::Index3>>& all() const { return tiles_; }

 private:
  std::map<Tile, std::set<voxnav::geometry::Index3>> tiles_;
};

/// A picture of the map with one marker for each tile. Only tiles whose markers differ from those sent before are sent
/// again; after restart() all are. Not thread-safe.
class TiledMarkers {
 public:
  using Marker = visualization_msgs::Marker;
  /// Fills points and colours of one tile. If the tile stays empty, its marker is deleted.
  using Draw = std::function<void(const std::vector<voxnav::geometry::Index3>& blocks, Marker* marker)>;

  /// @param blank  a marker with the fields that all markers share
  TiledMarkers(const Marker& blank, Draw draw) : blank_(blank), draw_(std::move(draw)) {}

  void mark(const Tile& tile) { due_.insert(tile); }
  /// Restarts the picture for a new subscriber: all tiles are due, and the next marker deletes all earlier ones.
  void restart(const MapTiles& tiles);
  void forget();
  bool is_due() const { return !due_.empty(); }
  /// The markers of the tiles that are due next, until there are `max_markers` of them, `max_points` points in all of
  /// them together, or no more tiles that are due. Of a tile that has more points every n-th is shown.
  std::vector<Marker> next(const MapTiles& tiles, const std_msgs::Header& header, std::size_t max_points,
                           std::size_t max_markers);

 private:
  struct Shown {
    std::int32_t id = 0;
    std::uint64_t sum = 0;  ///< checksum of the marker that was sent; 0 = none is shown
  };
  Marker blank_;
  Draw draw_;
  bool is_restarting_ = false;
  std::set<Tile> due_;
  std::map<Tile, Shown> shown_;
  std::int32_t next_id_ = 1;
};

}  // namespace voxnav_ros
