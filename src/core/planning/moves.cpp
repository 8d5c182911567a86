// SPDX-License-Identifier: BSD-3-Clause
#include "planning/moves.hpp"

namespace voxnav::planning {
namespace {

std::array<Move, kNumMoves> make_moves() {
  std::array<Move, kNumMoves> out;
  for (int move = 0; move < kNumMoves; ++move) {
    const geometry::Index3 step{move % 3 - 1, move / 3 % 3 - 1, move / 9 - 1};
    out[move].step = step;
    out[move].num_axes = (step.x != 0) + (step.y != 0) + (step.z != 0);
    out[move].touched = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const geometry::Index3 cell{(corner & 1) ? step.x : 0, (corner & 2) ? step.y : 0, (corner & 4) ? step.z : 0};
      if (move_of(cell) != kNoMove) out[move].touched |= 1u << move_of(cell);
    }
  }
  return out;
}

}  // namespace

const std::array<Move, kNumMoves>& moves() {
  static const std::array<Move, kNumMoves> kMoves = make_moves();
  return kMoves;
}

}  // namespace voxnav::planning
