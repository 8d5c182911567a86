// SPDX-License-Identifier: BSD-3-Clause
#include <set>
#include <stdexcept>
#include <utility>

#include "base/bytes.hpp"
#include "submap/files/map_files.hpp"
#include "submap/files/map_index.hpp"
#include "voxnav/submap/submap_collection.hpp"

namespace voxnav::submap {
namespace {

const char* const kIndexName = "index.vxi";

SubmapCollectionConfig settings_of(const MapIndex& index, const std::string& path,
                                   const SubmapCollectionConfig* wanted) {
  if (!wanted) return index.settings.value_or(SubmapCollectionConfig{});
  if (index.settings && index.settings->resolution_m != wanted->resolution_m) {
    throw std::invalid_argument(path + " has voxels of " + std::to_string(index.settings->resolution_m) + " m, not " +
                                std::to_string(wanted->resolution_m) + " m");
  }
  return *wanted;
}

}  // namespace

void SubmapCollection::save(const std::string& directory) const {
  make_directory(directory);
  MapIndexWriter index(config(), size());
  std::set<std::string> listed;
  const std::string folder = directory + "/";
  for (const SubmapEntry* entry : entries()) {
    const std::string bytes = entry->submap->to_bytes();
    const std::uint32_t sum = base::crc32(bytes.data(), bytes.size());
    const std::string name = submap_file_name(entry->id, sum);
    write_atomically(folder + name, bytes);
    index.add(*entry, sum);
    listed.insert(name);
  }
  sync_directory(directory);
  write_atomically(folder + kIndexName, index.finish());
  sync_directory(directory);
  remove_unlisted(directory, listed);
}

SubmapCollection SubmapCollection::load(const std::string& directory, std::vector<std::string>* problems,
                                        const SubmapCollectionConfig* config) {
  const std::string index_path = directory + "/" + kIndexName;
  const MapIndex index = read_map_index(index_path, problems);
  SubmapCollection out(settings_of(index, index_path, config));
  for (const MapIndex::Listed& listed : index.listed) {
    const std::string path = directory + "/" + submap_file_name(listed.entry.id, listed.sum);
    try {
      SubmapEntry entry = listed.entry;
      entry.submap = Submap::from_bytes(read_file(path));
      out.add(std::move(entry));
      out.page_out();
    } catch (const std::exception& error) {
      const std::string problem = path + ": " + error.what();
      if (!problems) throw std::invalid_argument(problem);
      problems->push_back(problem);
    }
  }
  return out;
}

}  // namespace voxnav::submap
