// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "instruction_sets.hpp"
#include "kernels/octree_levels.hpp"

using namespace voxnav;  // NOLINT: test

namespace {

using Voxels = std::array<std::uint8_t, kernels::kBlockVoxels>;
using Nodes = std::array<std::uint8_t, kernels::kBlockNodes>;

Voxels random_voxels(unsigned seed, bool are_alike) {
  std::mt19937 rng(seed);
  Voxels out;
  const auto same = static_cast<std::uint8_t>(rng());
  for (auto& voxel : out) voxel = are_alike && rng() % 300 != 0 ? same : static_cast<std::uint8_t>(rng());
  return out;
}

}  // namespace

TEST(OctreeLevels, FlagsAndSummariesEqualTheReference) {
  test::with_every_instruction_set([] {
    for (unsigned seed = 0; seed < 20; ++seed) {
      const Voxels levels = random_voxels(seed, seed % 2 == 0);
      const kernels::LevelFlags by{60, static_cast<std::uint8_t>(seed % 3 == 0 ? 255 : 140), 1, 2, 4};
      Voxels flags, expected_flags;
      kernels::flags_of_levels(levels.data(), by, flags.data());
      kernels::reference::flags_of_levels(levels.data(), by, expected_flags.data());
      ASSERT_EQ(flags, expected_flags);
      Nodes highest, united, expected_highest, expected_united;
      kernels::summarise_levels(levels.data(), flags.data(), highest.data(), united.data());
      kernels::reference::summarise_levels(levels.data(), flags.data(), expected_highest.data(),
                                           expected_united.data());
      ASSERT_EQ(highest, expected_highest);
      ASSERT_EQ(united, expected_united);
    }
  });
}
