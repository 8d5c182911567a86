// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "voxnav/submap/submap_collection.hpp"

/// The index of a saved map (docs/map_format.md): its settings, and for each submap all but its content.
namespace voxnav::submap {

/// The intact parts of an index.
struct MapIndex {
  struct Listed {
    SubmapEntry entry;      ///< without its submap
    std::uint32_t sum = 0;  ///< checksum of the submap's file
  };
  std::optional<SubmapCollectionConfig> settings;
  std::size_t num_submaps = 0;  ///< number of submaps according to the settings
  std::vector<Listed> listed;
};

/// Writes an index record by record.
class MapIndexWriter {
 public:
  MapIndexWriter(const SubmapCollectionConfig& config, std::size_t num_submaps);
  void add(const SubmapEntry& entry, std::uint32_t sum);
  std::string finish() { return out_.finish(); }

 private:
  void put_record(base::ByteWriter* record);
  base::ByteWriter out_;
};

/// @param problems  receives a description of each broken part, and the intact parts are returned; with null anything
///                  broken throws
/// @throws std::invalid_argument naming the file and what is wrong; in any case if nothing is intact or if the index is
///                               of another version
MapIndex read_map_index(const std::string& path, std::vector<std::string>* problems);

/// Returns the name of a submap file. It contains the checksum of the content, so that a save never overwrites a file
/// to which the present index refers.
std::string submap_file_name(std::uint32_t id, std::uint32_t sum);

}  // namespace voxnav::submap
