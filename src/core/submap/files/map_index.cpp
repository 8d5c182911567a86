// SPDX-License-Identifier: BSD-3-Clause
#include "submap/files/map_index.hpp"

#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "submap/files/map_files.hpp"

namespace voxnav::submap {
namespace {

constexpr base::Format kFormat{0x43535856, 1, "a voxnav map index"};  // "VXSC"
constexpr std::uint32_t kRecord = 0x43455256;  // "VREC", before every record, by which a reader finds the next one

void put_pose(const geometry::Pose& pose, base::ByteWriter* out) {
  out->put_raw(pose.matrix().data(), 16 * sizeof(double));
}

geometry::Pose get_pose(base::ByteReader* in) {
  geometry::Pose pose;
  in->get_raw(pose.matrix().data(), 16 * sizeof(double));
  if (!geometry::is_valid(pose) || pose.matrix().row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    in->fail("has an invalid pose");
  return pose;
}

void put_entry(const SubmapEntry& entry, std::uint32_t sum, base::ByteWriter* out) {
  out->put(entry.id);
  out->put(entry.flight);
  out->put(sum);
  out->put(entry.start_ns);
  out->put(entry.end_ns);
  put_pose(entry.T_O_S, out);
  put_pose(entry.T_W_S, out);
  put_pose(entry.bend.T_S_begin, out);
  put_pose(entry.bend.T_S_end, out);
  out->put<std::uint64_t>(entry.T_S_B.size());
  for (const geometry::StampedPose& pose : entry.T_S_B) {
    out->put(pose.stamp_ns);
    put_pose(pose.pose, out);
  }
}

SubmapEntry get_entry(base::ByteReader* in, std::uint32_t* sum) {
  SubmapEntry entry;
  entry.id = in->get<std::uint32_t>();
  entry.flight = in->get<std::uint32_t>();
  *sum = in->get<std::uint32_t>();
  entry.start_ns = in->get<base::StampNs>();
  entry.end_ns = in->get<base::StampNs>();
  entry.T_O_S = get_pose(in);
  entry.T_W_S = get_pose(in);
  entry.bend.T_S_begin = get_pose(in);
  entry.bend.T_S_end = get_pose(in);
  entry.T_S_B.resize(in->get_count(sizeof(base::StampNs) + 16 * sizeof(double)));
  for (geometry::StampedPose& pose : entry.T_S_B) {
    pose.stamp_ns = in->get<base::StampNs>();
    pose.pose = get_pose(in);
  }
  return entry;
}

void put_settings(const SubmapCollectionConfig& config, std::size_t num_submaps, base::ByteWriter* out) {
  out->put(config.resolution_m);
  out->put(config.clearing_distance_m);
  out->put(config.thin_range_m);
  out->put(config.pose_tolerance_m);
  out->put<std::int32_t>(config.max_submaps);
  out->put(config.max_memory_mb);
  out->put<std::uint64_t>(num_submaps);
}

SubmapCollectionConfig get_settings(base::ByteReader* in, std::size_t* num_submaps) {
  SubmapCollectionConfig config;
  config.resolution_m = in->get<double>();
  config.clearing_distance_m = in->get<double>();
  config.thin_range_m = in->get<double>();
  config.pose_tolerance_m = in->get<double>();
  config.max_submaps = in->get<std::int32_t>();
  config.max_memory_mb = in->get<double>();
  if (!base::problems_of(config).empty()) in->fail("has settings out of range");
  *num_submaps = in->get<std::uint64_t>();
  return config;
}

/// Reads one record. The first record holds the settings, all others a submap each.
void take_record(const std::string& bytes, bool is_first, const std::string& name, MapIndex* index) {
  base::ByteReader in(bytes, name);
  if (is_first) {
    index->settings = get_settings(&in, &index->num_submaps);
  } else {
    MapIndex::Listed listed;
    listed.entry = get_entry(&in, &listed.sum);
    index->listed.push_back(std::move(listed));
  }
  if (in.remaining() != 0) in.fail("has a record of the wrong length");
}

/// Reads every record whose checksum fits; after a broken record it searches for the next mark.
/// @param problem  receives the reason of the first broken record; with null the first broken record throws
void read_records(const std::string& bytes, const std::string& name, std::string* problem, MapIndex* index) {
  constexpr std::size_t kFirst = 2 * sizeof(std::uint32_t);
  const std::string mark(reinterpret_cast<const char*>(&kRecord), sizeof(kRecord));
  std::size_t at = kFirst;
  while ((at = bytes.find(mark, at)) != std::string::npos) {
    std::uint32_t size = 0;
    const std::size_t start = at + 2 * sizeof(std::uint32_t);
    if (start > bytes.size()) break;
    std::memcpy(&size, bytes.data() + at + sizeof(kRecord), sizeof(size));
    try {
      if (size > bytes.size() - start) throw std::invalid_argument(name + " ends within a record");
      take_record(bytes.substr(start, size), at == kFirst, name, index);
      at = start + size;
    } catch (const std::invalid_argument& error) {
      if (!problem) throw;
      if (problem->empty()) *problem = error.what();
      at += mark.size();
    }
  }
}

}  // namespace

std::string submap_file_name(std::uint32_t id, std::uint32_t sum) {
  char name[48];
  std::snprintf(name, sizeof(name), "submap_%06u_%08x.vxs", id, sum);
  return name;
}

MapIndexWriter::MapIndexWriter(const SubmapCollectionConfig& config, std::size_t num_submaps) {
  out_.put_header(kFormat);
  base::ByteWriter settings;
  put_settings(config, num_submaps, &settings);
  put_record(&settings);
}

void MapIndexWriter::add(const SubmapEntry& entry, std::uint32_t sum) {
  base::ByteWriter record;
  put_entry(entry, sum, &record);
  put_record(&record);
}

void MapIndexWriter::put_record(base::ByteWriter* record) {
  const std::string bytes = record->finish();
  out_.put(kRecord);
  out_.put(static_cast<std::uint32_t>(bytes.size()));
  out_.put_raw(bytes.data(), bytes.size());
}

MapIndex read_map_index(const std::string& path, std::vector<std::string>* problems) {
  const std::string bytes = read_file(path);
  std::string problem;
  MapIndex index;
  std::optional<base::ByteReader> whole;
  try {
    whole.emplace(bytes, path);
  } catch (const std::invalid_argument& error) {
    if (!problems) throw;
    problem = error.what();
  }
  // An intact index of another version is not damaged: guessing at its records would give wrong submaps.
  if (whole) whole->check_header(kFormat);
  read_records(bytes, path, problems ? &problem : nullptr, &index);
  const bool is_whole = index.settings && index.listed.size() == index.num_submaps;
  if (!is_whole && problem.empty()) problem = path + " does not hold what it announces";
  if (problem.empty()) return index;
  if (!problems || index.listed.empty()) throw std::invalid_argument(problem);
  const std::string of = index.settings ? " of " + std::to_string(index.num_submaps) : "";
  problems->push_back(problem + "; " + std::to_string(index.listed.size()) + of + " submaps are intact in it");
  return index;
}

}  // namespace voxnav::submap
