// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::planning {

/// Moves are numbered 0 to 26: (x + 1) + 3 (y + 1) + 9 (z + 1) for a step (x, y, z); number 13 stands still.
constexpr int kNumMoves = 27;
constexpr int kNoMove = 13;

inline int move_of(const geometry::Index3& step) { return (step.x + 1) + 3 * (step.y + 1) + 9 * (step.z + 1); }

/// A move: its step, the number of axes along which it goes, and the cells of the 3^3 neighbourhood that it touches
/// (one bit for each move number). A move is possible if all of them may be entered, so that a path cuts no corner.
struct Move {
  geometry::Index3 step;
  int num_axes;
  std::uint32_t touched;
};
const std::array<Move, kNumMoves>& moves();

}  // namespace voxnav::planning
