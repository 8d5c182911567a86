// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "voxnav/geometry/pose.hpp"
#include "voxnav/submap/evidence_map.hpp"
#include "voxnav/submap/submap.hpp"

namespace voxnav::submap {

/// A submap with its time span, its poses and its pose history.
struct SubmapEntry {
  std::uint32_t id = 0;
  std::uint32_t flight = 0;  ///< number of the flight; later flights are newer, whatever their stamps are
  base::StampNs start_ns = 0;
  base::StampNs end_ns = 0;
  geometry::Pose T_O_S = geometry::Pose::Identity();
  geometry::Pose T_W_S = geometry::Pose::Identity();  ///< optimised pose, which holds for the middle of its time
  geometry::Bend bend;
  std::vector<geometry::StampedPose> T_S_B;  ///< pose history
  std::shared_ptr<const Submap> submap;
};

/// All finished submaps and the map merged from them in the frame W. A submap contributes what it observed itself: the
/// content that its local map remembered was observed by submaps before it, which contribute it where they lie now. If
/// the submap before it is absent (after a restart, or beyond a limit), its remembered content counts too, but only in
/// blocks of which no older submap knows anything and which no other submap observed, since remembered content in the
/// wrong place would stand beside the right one. Not thread-safe.
class SubmapCollection {
 public:
  explicit SubmapCollection(const SubmapCollectionConfig& config);
  ~SubmapCollection();
  SubmapCollection(SubmapCollection&&) noexcept;
  SubmapCollection& operator=(SubmapCollection&&) noexcept;

  /// Adds a submap, which replaces one of the same id. Submaps are ordered by age: the flight, then the end stamp, then
  /// the id.
  /// @throws std::invalid_argument without a submap or with an invalid pose
  void add(SubmapEntry entry);
  /// Moves a submap.
  /// @param bend  drift within the submap
  /// @return false if there is no such submap
  bool set_pose(std::uint32_t id, const geometry::Pose& T_W_S, const geometry::Bend& bend = {});
  bool remove(std::uint32_t id);
  void clear();

  const SubmapEntry* find(std::uint32_t id) const;
  /// Returns all submaps, oldest first.
  std::vector<const SubmapEntry*> entries() const;
  /// Returns the newest submap; null if there is none.
  const SubmapEntry* newest() const;
  std::size_t size() const;
  std::uint64_t num_dropped() const;

  /// Brings the merged map up to date. The cost depends on the submaps that are new or moved: O(their blocks * submaps
  /// that overlap there). @return blocks that changed, sorted
  std::vector<geometry::Index3> update();
  /// The merged map as of the last update().
  const EvidenceMap& evidence() const;

  // The queries below bring the merged map up to date first.

  /// Believed surface points [m, frame W], by blocks.
  std::vector<geometry::Vec3f> occupied_points();
  containers::StateGrid obstacles(double safety_distance_m);
  containers::VoxelState state(const geometry::Vec3& p_W);
  /// Returns the distance to the nearest believed surface point, at most max_distance_m; nothing where the map is
  /// unknown.
  std::optional<double> distance(const geometry::Vec3& p_W, double max_distance_m);
  /// Returns the unit vector away from the nearest believed surface point, zero if none is within max_distance_m;
  /// nothing where the map is unknown.
  std::optional<geometry::Vec3> gradient(const geometry::Vec3& p_W, double max_distance_m);
  /// The first voxel on the segment from a to b that is not known to be free.
  struct Ray {
    containers::VoxelState state =
        containers::VoxelState::kFree;  ///< state of that voxel; free = the whole segment is free
    double distance_m = 0.0;            ///< distance from a to that voxel, or to b
  };
  /// @throws std::invalid_argument unless both ends are finite and less than 10 km apart
  Ray cast_ray(const geometry::Vec3& a_W, const geometry::Vec3& b_W);
  /// Lists what appeared or disappeared between submaps; see scene_changes().
  std::vector<SceneChange> changes(std::size_t min_voxels = 10);

  /// Takes over the submaps of another map as newer flights. Their ids are shifted behind those of this map.
  /// @return number that was added to their ids
  /// @throws std::invalid_argument on another resolution or an invalid pose
  std::uint32_t merge(const SubmapCollection& other, const geometry::Pose& T_W_other);
  /// The number of submaps in memory; the others are in page_dir.
  std::size_t num_resident() const;

  const SubmapCollectionConfig& config() const;
  std::size_t memory_bytes() const;

  /// Saves every submap and an index to `directory`. Each file is written under another name, synced and renamed, the
  /// index last, so that a crash leaves the map that was saved before.
  /// @throws std::runtime_error naming file and reason
  void save(const std::string& directory) const;
  /// Loads a saved map.
  /// @param problems  receives a description of each broken submap or part of the index, which is left out; with null
  ///                  anything broken throws
  /// @param config    settings to use instead of the saved ones, such as limits and page_dir; null = the saved ones
  /// @throws std::invalid_argument or std::runtime_error if the index is absent, nothing of it is intact, or the
  ///         resolution of `config` is not that of the map
  static SubmapCollection load(const std::string& directory, std::vector<std::string>* problems = nullptr,
                               const SubmapCollectionConfig* config = nullptr);

 private:
  void page_out();

  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Writes the known voxels of the merged map as a pruned OctoMap: `.ot` (log-odds) or `.bt` (occupied and free) by the
/// ending of the path. Source of the format: Hornung et al., OctoMap, Autonomous Robots 2013.
/// A map beyond the reach of an OctoMap is shifted as in occupancy::save_octomap().
/// @return  what must be added to coordinates in the file to get those of the map; none where they are the same
/// @throws std::invalid_argument for another ending, std::runtime_error if the file cannot be written,
///         std::length_error for a map that is wider than an OctoMap
std::optional<geometry::Vec3> save_octomap(const EvidenceMap& evidence, const std::string& path);

/// Makes a map of an OctoMap file (.ot or .bt), divided into submaps of 77 m with voxels of 0.4 m. What OctoMap calls
/// occupied is a surface in the middle of its voxel; everything else that the file knows is free. The submaps have no
/// times and no poses of a vehicle.
/// @throws std::runtime_error naming the file if it cannot be read, has voxels of another size than `config`, or knows
///         more than 800 million voxels
SubmapCollection load_octomap(const std::string& path, const SubmapCollectionConfig& config,
                              const SubmapConfig& submap_config = {});

/// Returns the merged map as the data of an octomap_msgs/Octomap with id "OcTree"; `binary` is the field of that
/// message.
/// @throws std::length_error for a map beyond the reach of an OctoMap, since a message cannot state a shift
std::vector<std::int8_t> octomap_message_data(const EvidenceMap& evidence, bool binary);

/// Writes the surface points of each submap in its own frame as `submap_<id>.ply`, and their poses in `poses.txt`: one
/// line `id end_stamp_s x y z qx qy qz qw` (T_W_S) for each submap, oldest first. The directory must exist.
/// @throws std::runtime_error naming the file that cannot be written
void save_clouds(const SubmapCollection& collection, const std::string& directory);

/// Exports the map for other programs to a directory, which is created if needed: `mesh.ply`, `occupied.ply` (believed
/// surface points), `map.ot`, and the files of save_clouds().
/// @return  what save_octomap() returns
/// @throws as save_octomap(), and std::runtime_error naming the file that cannot be written
std::optional<geometry::Vec3> export_all(SubmapCollection* collection, const std::string& directory);

}  // namespace voxnav::submap
