// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "planning/path/run_graph.hpp"

namespace voxnav::planning {

/// Which cells a line of sight may touch.
enum class SightRule {
  kEnterable,    ///< cells that searches may enter
  kExactlyClear  ///< also cells whose centre is too near to an obstacle: whoever asks checks the clearance of the line
};

/// The cost of a straight line between two points [voxel edges at unit cost], integrated over the cells that it
/// touches; nothing if it touches others than the rule allows. O(columns that it crosses).
std::optional<double> sight_cost(RunGraph* graph, const geometry::Vec3& from, const geometry::Vec3& to, SightRule rule);

/// A way over the centres of the cells that a line of sight touches, which cuts no corner. Precondition: the line is
/// one by SightRule::kEnterable.
std::vector<geometry::Vec3> cells_along(const geometry::Vec3& from, const geometry::Vec3& to);

}  // namespace voxnav::planning
