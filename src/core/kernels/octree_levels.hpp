// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace voxnav::kernels {

/// Voxels of a block of 16^3, in the order x + 16 y + 256 z, and the nodes above them: levels of 8^3, 4^3, 2^3
/// and 1, one behind the other, each in the same order.
constexpr int kBlockVoxels = 4096;
constexpr int kBlockNodes = 512 + 64 + 8 + 1;

/// The limits between free, unknown and occupied log-odds levels, and the flag of each state.
struct LevelFlags {
  std::uint8_t free_end;        ///< lower levels are free
  std::uint8_t occupied_begin;  ///< levels from here on are occupied, the others unknown
  std::uint8_t if_free, if_unknown, if_occupied;
};

/// Computes flags[i] of each voxel from its level.
void flags_of_levels(const std::uint8_t* levels, const LevelFlags& by, std::uint8_t* flags);

/// Computes for every inner node the highest level of the voxels below it and the union of their flags.
void summarise_levels(const std::uint8_t* levels, const std::uint8_t* flags, std::uint8_t* highest,
                      std::uint8_t* united);

namespace reference {
void flags_of_levels(const std::uint8_t* levels, const LevelFlags& by, std::uint8_t* flags);
void summarise_levels(const std::uint8_t* levels, const std::uint8_t* flags, std::uint8_t* highest,
                      std::uint8_t* united);
}  // namespace reference

}  // namespace voxnav::kernels
