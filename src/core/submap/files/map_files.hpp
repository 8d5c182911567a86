// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <string>

/// Files of a saved map. All functions throw std::runtime_error naming the file and the reason.
namespace voxnav::submap {

std::string read_file(const std::string& path);
/// Replaces a file. It holds the old bytes or the new ones, never a part, whatever interrupts the call.
void write_atomically(const std::string& path, const std::string& bytes);
/// Makes a directory with all directories above it.
void make_directory(const std::string& path);
/// Makes sure that what was renamed in a directory stays renamed after a loss of power.
void sync_directory(const std::string& directory);
/// Removes the submap files that are not in the list.
void remove_unlisted(const std::string& directory, const std::set<std::string>& listed);

}  // namespace voxnav::submap
