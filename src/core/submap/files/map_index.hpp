// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "voxnav/submap/submap_collection.hpp"

/// The index of a saved map (docs/map_format.md): its settings, and what is known of each submap but its content.
namespace voxnav::submap {

/// What is intact of an index.
struct MapIndex {
  struct Listed {
    SubmapEntry entry;      ///< without its submap
    std::uint32_t sum = 0;  ///< checksum of its file
  };
  std::optional<SubmapCollectionConfig> settings;
  std::size_t num_submaps = 0;  ///< as the settings say
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

/// @param problems  null: anything broken throws; else it is described there, and what is intact is returned
/// @throws std::invalid_argument naming the file and what is wrong; always when nothing is intact or when the index is
/// of another version
MapIndex read_map_index(const std::string& path, std::vector<std::string>* problems);

/// A submap file is named after its content, so that a save never overwrites one that the index in place refers to.
std::string submap_file_name(std::uint32_t id, std::uint32_t sum);

}  // namespace voxnav::submap
