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
  std::optional<submap::ProjectiveConfig> projective;  ///< none: submaps are filled by the occupancy of handovers
  double projective_period_s = 0.0;                    ///< age at which a submap of clouds closes; 0: with handovers
  int max_open_submaps = 4;                            ///< submaps of which early content is kept, at least 1
};

/// Makes finished submaps of what the local map hands over. Content that left the local map's window early waits here
/// until the last part of its submap comes; both are then filled into one submap. With a ProjectiveConfig submaps are
/// filled from clouds instead, and handovers say only when one ends. Not thread-safe.
class SubmapAssembler {
 public:
  struct Result {
    std::optional<submap::SubmapEntry> submap;  ///< finished by this handover; T_W_S is T_O_S, flight is 0
    std::optional<std::string> dropped;         ///< why early content of some submap was given up, a whole sentence
  };

  /// @throws std::invalid_argument without room for one open submap, base::ConfigError on a bad configuration
  explicit SubmapAssembler(SubmapAssemblerConfig config);

  /// Takes the next handover. Early content is kept for max_open_submaps submaps; that of the lowest id is given up
  /// when there are more, because its last part was lost or will come without it.
  /// @throws std::invalid_argument when the content does not fit the early content of its submap; a submap whose last
  ///         part does not fit is lost
  Result add(const Handover& handover);

  bool is_projective() const { return integrator_.has_value(); }
  /// Fuses one cloud into the submap that is open. @param points_L sensor frame, m  @param T_O_L at stamp_ns
  /// @throws std::logic_error unless is_projective(), std::invalid_argument on an invalid pose
  void integrate(const std::vector<geometry::Vec3f>& points_L, const geometry::Pose& T_O_L, base::StampNs stamp_ns);
  /// Whether the submap of clouds is as old as projective_period_s, or time went back since it was opened.
  bool is_due() const;
  /// Finishes the submap of clouds, and opens the next. @throws std::logic_error unless is_projective()
  submap::SubmapEntry close();

  std::size_t num_open() const { return early_.size(); }

 private:
  submap::SubmapEntry fill(const Handover& handover, const occupancy::MapContent& content) const;
  submap::SubmapEntry close_as(submap::SubmapEntry entry);

  SubmapAssemblerConfig config_;
  std::map<std::uint32_t, occupancy::MapContent> early_;  ///< by submap id
  std::optional<submap::ProjectiveIntegrator> integrator_;
  submap::SubmapEntry open_;  ///< submap of clouds; its pose history is empty before the first one
};

}  // namespace voxnav::pipeline
