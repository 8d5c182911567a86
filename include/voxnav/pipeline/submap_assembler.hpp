// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "voxnav/pipeline/submap_scheduler.hpp"
#include "voxnav/submap/projective_integrator.hpp"
#include "voxnav/submap/submap_collection.hpp"

namespace voxnav::pipeline {

struct SubmapAssemblerConfig {
  submap::SubmapConfig submap;
  std::optional<submap::ProjectiveConfig> projective;  ///< if set, submaps are filled from clouds, not from handovers
  double projective_period_s = 0.0;                    ///< age at which a submap of clouds closes; 0 = with handovers
  int max_open_submaps = 4;                            ///< number of submaps whose early content is kept, at least 1
};

/// Assembles the handovers of a local map into finished submaps. Early content, which left the window of the local map
/// while its submap was open, waits here until the last part of the submap comes; both are then filled into one submap.
/// With a ProjectiveConfig submaps are filled from clouds instead, and handovers only tell when one ends. Not
/// thread-safe.
class SubmapAssembler {
 public:
  struct Result {
    std::optional<submap::SubmapEntry> submap;  ///< submap that this handover completed; T_W_S is T_O_S, flight is 0
    std::optional<std::string> dropped;         ///< if early content of a submap was dropped: why, as a sentence
  };

  /// @throws std::invalid_argument without room for one open submap, base::ConfigError on a bad configuration
  explicit SubmapAssembler(const SubmapAssemblerConfig& config);

  /// Adds the next handover. Early content is kept for max_open_submaps submaps. If there are more, that of the lowest
  /// id is dropped: its last part was lost, or will make a submap without it.
  /// @throws std::invalid_argument if the content does not fit the early content of its submap; a submap whose last
  /// part
  ///         does not fit is lost
  Result add(const Handover& handover);

  bool is_projective() const { return integrator_.has_value(); }
  /// Fuses one cloud into the open submap.
  /// @param points_L  points in the sensor frame, m
  /// @param T_O_L     pose of the sensor at stamp_ns
  /// @throws std::logic_error unless is_projective(), std::invalid_argument on an invalid pose
  void integrate(const std::vector<geometry::Vec3f>& points_L, const geometry::Pose& T_O_L, base::StampNs stamp_ns);
  /// Returns true if the submap of clouds is as old as projective_period_s, or if time went back since it was opened.
  bool is_due() const;
  /// Finishes the submap of clouds and opens the next one. @throws std::logic_error unless is_projective()
  submap::SubmapEntry close();

  std::size_t num_open() const { return early_.size(); }

 private:
  submap::SubmapEntry fill(const Handover& handover, const occupancy::MapContent& content) const;
  submap::SubmapEntry close_as(submap::SubmapEntry entry);

  SubmapAssemblerConfig config_;
  std::map<std::uint32_t, occupancy::MapContent> early_;  ///< early content by id of the submap
  std::optional<submap::ProjectiveIntegrator> integrator_;
  submap::SubmapEntry open_;  ///< submap of clouds; its pose history is empty before the first one
};

}  // namespace voxnav::pipeline
