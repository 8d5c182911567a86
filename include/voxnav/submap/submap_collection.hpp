// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "voxnav/geometry/bend.hpp"
#include "voxnav/geometry/pose.hpp"
#include "voxnav/submap/evidence_map.hpp"
#include "voxnav/submap/scene_changes.hpp"
#include "voxnav/submap/submap.hpp"

namespace voxnav::submap {

struct SubmapCollectionConfig {
  double resolution_m = 0.4;
  double clearing_distance_m = 0.4;
  double thin_range_m = 6.0;
  double pose_tolerance_m = 0.02;
  int max_submaps = 5000;
  double max_memory_mb = 2000.0;
  double max_resident_mb = 100.0;
  std::string page_dir = "";

  template <class V>
  static void fields(V&& v) {
    v("resolution_m", &SubmapCollectionConfig::resolution_m, base::in(0.05, 5.0), "m", "voxel edge of the merged map");
    v("clearing_distance_m", &SubmapCollectionConfig::clearing_distance_m, base::in(0.0, 5.0), "m",
      "newer free space removes an older surface unless the newer submap has one of its own nearer than this");
    v("thin_range_m", &SubmapCollectionConfig::thin_range_m, base::in(0.0, 100.0), "m",
      "wires and poles are removed only by free space seen from this near, or from as near as they were");
    v("pose_tolerance_m", &SubmapCollectionConfig::pose_tolerance_m, base::in(0.0, 1.0), "m",
      "a submap is merged anew when a corner of its box moved farther than this");
    v("max_submaps", &SubmapCollectionConfig::max_submaps, base::in(1, 1000000), "",
      "the oldest submap is dropped beyond");
    v("max_memory_mb", &SubmapCollectionConfig::max_memory_mb, base::in(1.0, 1e6), "MB",
      "the oldest submap is dropped while submaps take more");
    v("max_resident_mb", &SubmapCollectionConfig::max_resident_mb, base::in(1.0, 1e6), "MB",
      "submaps beyond rest in page_dir, those not used for longest first");
    v("page_dir", &SubmapCollectionConfig::page_dir, base::any(), "",
      "where submaps rest that are not in memory; empty = all stay in memory");
  }
};

/// A submap with what is known about how it was made.
struct SubmapEntry {
  std::uint32_t id = 0;
  std::uint32_t flight = 0;  ///< later flights are newer, whatever their clocks said
  base::StampNs start_ns = 0;
  base::StampNs end_ns = 0;
  geometry::Pose T_O_S = geometry::Pose::Identity();
  geometry::Pose T_W_S = geometry::Pose::Identity();  ///< pose of its middle, as the graph has it
  geometry::Bend bend;
  std::vector<geometry::StampedPose> T_S_B;  ///< pose history
  std::shared_ptr<const Submap> submap;
};

/// All finished submaps and what they say together in the map frame W. A submap says what it observed itself: what its
/// local map remembered was observed by submaps before it, which say so where they lie now. Where the one before it is
/// absent (after a restart, or beyond a limit) its memory counts too, in blocks of which no older submap knows anything
/// and no other one observed anything: memory that lies wrong would stand beside what is right. Not thread-safe.
class SubmapCollection {
 public:
  explicit SubmapCollection(const SubmapCollectionConfig& config);
  ~SubmapCollection();
  SubmapCollection(SubmapCollection&&) noexcept;
  SubmapCollection& operator=(SubmapCollection&&) noexcept;

  /// Replaces a submap of the same id. Age is the flight, then the end stamp, then the id.
  /// @throws std::invalid_argument without a submap or with an invalid pose
  void add(SubmapEntry entry);
  /// Moves a submap. @param bend  what drift did to it while it was made
  /// @return false when there is no such submap
  bool set_pose(std::uint32_t id, const geometry::Pose& T_W_S, const geometry::Bend& bend = {});
  bool remove(std::uint32_t id);
  void clear();

  const SubmapEntry* find(std::uint32_t id) const;
  /// Oldest first.
  std::vector<const SubmapEntry*> entries() const;
  /// Null when there is none.
  const SubmapEntry* newest() const;
  std::size_t size() const;
  std::uint64_t num_dropped() const;

  /// Brings the merged evidence up to date. Cost follows the submaps that are new or moved: O(their blocks * submaps
  /// that overlap there). @return blocks that changed, sorted
  std::vector<geometry::Index3> update();
  /// As of the last update().
  const EvidenceMap& evidence() const;

  // The queries below bring the evidence up to date first.

  /// Believed surface points [m, frame W], by blocks.
  std::vector<geometry::Vec3f> occupied_points();
  containers::StateGrid obstacles(double safety_distance_m);
  containers::State state(const geometry::Vec3& p_W);
  /// Distance to the nearest believed surface point, at most max_distance_m; nothing where W is unknown.
  std::optional<double> distance(const geometry::Vec3& p_W, double max_distance_m);
  /// Unit vector away from that surface, zero when none is that near; nothing where W is unknown.
  std::optional<geometry::Vec3> gradient(const geometry::Vec3& p_W, double max_distance_m);
  /// First voxel on the way from a to b that is not known to be free.
  struct Ray {
    containers::State state = containers::State::kFree;  ///< free = all of the way is
    double distance_m = 0.0;                             ///< from a to that voxel, or to b
  };
  /// @throws std::invalid_argument unless both ends are finite and less than 10 km apart
  Ray cast_ray(const geometry::Vec3& a_W, const geometry::Vec3& b_W);
  /// Things that appeared or disappeared between submaps; see scene_changes().
  std::vector<SceneChange> changes(std::size_t min_voxels = 10);

  /// Takes the submaps of another map over, as newer flights; their ids are shifted behind the ones here.
  /// @return what was added to their ids  @throws std::invalid_argument on another resolution or an invalid pose
  std::uint32_t merge(const SubmapCollection& other, const geometry::Pose& T_W_other);
  /// How many submaps are in memory; the others rest in page_dir.
  std::size_t num_resident() const;

  const SubmapCollectionConfig& config() const;
  std::size_t memory_bytes() const;

  /// Writes every submap and an index into `directory`. Each file is written beside its name, synced and renamed, the
  /// index last, so that a crash leaves the state before. @throws std::runtime_error naming file and reason
  void save(const std::string& directory) const;
  /// @param problems  null: whatever is broken throws; else it is left out and described there, also parts of the index
  /// @param config  null: as saved; else these settings, limits and page_dir above all
  /// @throws std::invalid_argument or std::runtime_error when the index is absent, nothing of it is intact, or the
  /// voxels of the configuration are not those of the map
  static SubmapCollection load(const std::string& directory, std::vector<std::string>* problems = nullptr,
                               const SubmapCollectionConfig* config = nullptr);

 private:
  void page_out();

  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace voxnav::submap
