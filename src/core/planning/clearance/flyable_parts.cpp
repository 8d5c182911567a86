// SPDX-License-Identifier: BSD-3-Clause
#include "planning/clearance/flyable_parts.hpp"

#include <algorithm>

namespace voxnav::planning {
namespace {

constexpr int kSide = geometry::kBlockSide;

/// Finds the representative of a run; halves the way to it.
std::uint16_t root_of(std::vector<std::uint16_t>* parents, std::uint16_t run) {
  std::vector<std::uint16_t>& parent = *parents;
  while (parent[run] != run) {
    parent[run] = parent[parent[run]];
    run = parent[run];
  }
  return run;
}

std::uint32_t starts_of(std::uint32_t bits) { return bits & ~(bits << 1); }

/// Position among the runs of a column of the one that holds z.
int run_at(std::uint16_t bits, int z) { return __builtin_popcount(starts_of(bits) & ((2u << z) - 1u)) - 1; }

}  // namespace

void FlyableParts::assign(const BlockColumns& flyable) {
  parts_.clear();
  for (int column = 0; column < kColumns; ++column) {
    first_run_[column] = static_cast<std::uint16_t>(parts_.size());
    for (int n = __builtin_popcount(starts_of(flyable[column])); n > 0; --n) {
      parts_.push_back(static_cast<std::uint16_t>(parts_.size()));
    }
  }
  first_run_[kColumns] = static_cast<std::uint16_t>(parts_.size());
  const auto unite = [&](int a, int b) {
    for_each_run(flyable[a] & flyable[b], [&](int low, int) {
      const auto run_a = static_cast<std::uint16_t>(first_run_[a] + run_at(flyable[a], low));
      const auto run_b = static_cast<std::uint16_t>(first_run_[b] + run_at(flyable[b], low));
      const std::uint16_t root_a = root_of(&parts_, run_a), root_b = root_of(&parts_, run_b);
      parts_[std::max(root_a, root_b)] = std::min(root_a, root_b);
    });
  };
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      if (x + 1 < kSide) unite(column_at(x, y), column_at(x + 1, y));
      if (y + 1 < kSide) unite(column_at(x, y), column_at(x, y + 1));
    }
  }
  // The lowest run of a part is its representative, so it is met first.
  num_parts_ = 0;
  for (std::size_t run = 0; run < parts_.size(); ++run) {
    const std::uint16_t parent = parts_[run];
    parts_[run] = parent == run ? static_cast<std::uint16_t>(num_parts_++) : parts_[parent];
  }
}

int FlyableParts::part_of(const BlockColumns& flyable, int column, int z) const {
  if (((flyable[column] >> z) & 1) == 0) return kNone;
  return parts_[first_run_[column] + run_at(flyable[column], z)];
}

FlyableParts::Contacts FlyableParts::contacts(const Side& low, const Side& high, int axis) {
  Contacts out;
  const auto touch = [&](int a, int z_a, int b, int z_b) {
    const std::pair<std::uint16_t, std::uint16_t> pair(low.parts->part_of(*low.flyable, a, z_a),
                                                       high.parts->part_of(*high.flyable, b, z_b));
    if (out.empty() || out.back() != pair) out.push_back(pair);
  };
  if (axis == 2) {
    for (int column = 0; column < kColumns; ++column) {
      const bool touches = ((*low.flyable)[column] >> (kSide - 1)) != 0 && ((*high.flyable)[column] & 1) != 0;
      if (touches) touch(column, kSide - 1, column, 0);
    }
  } else {
    for (int i = 0; i < kSide; ++i) {
      const int a = axis == 0 ? column_at(kSide - 1, i) : column_at(i, kSide - 1);
      const int b = axis == 0 ? column_at(0, i) : column_at(i, 0);
      for_each_run((*low.flyable)[a] & (*high.flyable)[b], [&](int z, int) { touch(a, z, b, z); });
    }
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

std::vector<std::uint16_t> FlyableParts::parts_at_face(const BlockColumns& flyable, int face) const {
  std::vector<std::uint16_t> out;
  const int last = (face % 2) * (kSide - 1);
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const int column = face < 2 ? column_at(last, i) : face < 4 ? column_at(i, last) : column_at(i, j);
      const int part = part_of(flyable, column, face < 4 ? j : last);
      if (part != kNone) out.push_back(static_cast<std::uint16_t>(part));
    }
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

}  // namespace voxnav::planning
