// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <string>

/// File operations for saved maps. All functions throw std::runtime_error naming the file and the reason.
namespace voxnav::submap {

std::string read_file(const std::string& path);
/// Replaces a file atomically: whatever interrupts the call, the file holds all of the old bytes or all of the new
/// ones.
void write_atomically(const std::string& path, const std::string& bytes);
/// Creates a directory and all its parent directories.
void make_directory(const std::string& path);
/// Syncs a directory, so that files renamed in it stay renamed after a loss of power.
void sync_directory(const std::string& directory);
/// Removes the submap files of a directory that are not in the list.
void remove_unlisted(const std::string& directory, const std::set<std::string>& listed);

}  // namespace voxnav::submap
