// SPDX-License-Identifier: BSD-3-Clause
#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <set>

#include "voxnav/base/bytes.hpp"
#include "voxnav/submap/submap_collection.hpp"

namespace voxnav::submap {
namespace {

constexpr std::uint32_t kMagic = 0x43535856;  // "VXSC"
constexpr std::uint32_t kVersion = 1;
const char* const kIndexName = "index.vxi";

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw std::runtime_error(path + ": " + what + ": " + std::strerror(errno));
}

void write_all(int file, const std::string& bytes, const std::string& path) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t written = ::write(file, bytes.data() + done, bytes.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      ::close(file);
      fail(path, "cannot be written");
    }
    done += static_cast<std::size_t>(written);
  }
}

/// The file holds the old bytes or the new ones, never a part.
void write_atomically(const std::string& path, const std::string& bytes) {
  const std::string temporary = path + ".part";
  const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file < 0) fail(temporary, "cannot be created");
  write_all(file, bytes, temporary);
  const bool is_synced = ::fsync(file) == 0;
  if (::close(file) != 0 || !is_synced) fail(temporary, "cannot be written");
  if (::rename(temporary.c_str(), path.c_str()) != 0) fail(path, "cannot be replaced");
}

void sync_directory(const std::string& directory) {
  const int handle = ::open(directory.c_str(), O_RDONLY);
  if (handle < 0) return;
  ::fsync(handle);
  ::close(handle);
}

void make_directory(const std::string& path) {
  for (std::size_t slash = path.find('/', 1); slash != std::string::npos; slash = path.find('/', slash + 1)) {
    ::mkdir(path.substr(0, slash).c_str(), 0755);
  }
  if (::mkdir(path.c_str(), 0755) != 0 && errno != EEXIST) fail(path, "cannot be created");
}

std::string read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error(path + ": cannot be read");
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// Named after its content, so that a save never overwrites a file that the index in place refers to.
std::string file_name(std::uint32_t id, std::uint32_t sum) {
  char name[48];
  std::snprintf(name, sizeof(name), "submap_%06u_%08x.vxs", id, sum);
  return name;
}

void remove_unlisted(const std::string& directory, const std::set<std::string>& listed) {
  DIR* handle = ::opendir(directory.c_str());
  if (!handle) return;
  while (const dirent* item = ::readdir(handle)) {
    const std::string name = item->d_name;
    if (name.compare(0, 7, "submap_") == 0 && listed.count(name) == 0) ::unlink((directory + "/" + name).c_str());
  }
  ::closedir(handle);
}

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
  out->put(sum);
  out->put(entry.start_ns);
  out->put(entry.end_ns);
  put_pose(entry.T_O_S, out);
  put_pose(entry.T_W_S, out);
  out->put<std::uint64_t>(entry.T_S_B.size());
  for (const geometry::StampedPose& pose : entry.T_S_B) {
    out->put(pose.stamp_ns);
    put_pose(pose.pose, out);
  }
}

SubmapEntry get_entry(base::ByteReader* in, std::uint32_t* sum) {
  SubmapEntry entry;
  entry.id = in->get<std::uint32_t>();
  *sum = in->get<std::uint32_t>();
  entry.start_ns = in->get<base::StampNs>();
  entry.end_ns = in->get<base::StampNs>();
  entry.T_O_S = get_pose(in);
  entry.T_W_S = get_pose(in);
  entry.T_S_B.resize(in->get_count(sizeof(base::StampNs) + 16 * sizeof(double)));
  for (geometry::StampedPose& pose : entry.T_S_B) {
    pose.stamp_ns = in->get<base::StampNs>();
    pose.pose = get_pose(in);
  }
  return entry;
}

SubmapCollectionConfig get_config(base::ByteReader* in) {
  SubmapCollectionConfig config;
  config.resolution_m = in->get<double>();
  config.clearing_distance_m = in->get<double>();
  config.pose_tolerance_m = in->get<double>();
  config.max_submaps = in->get<std::int32_t>();
  config.max_memory_mb = in->get<double>();
  if (!base::problems_of(config).empty()) in->fail("has settings out of range");
  return config;
}

}  // namespace

void SubmapCollection::save(const std::string& directory) const {
  make_directory(directory);
  base::ByteWriter index;
  index.put(kMagic);
  index.put(kVersion);
  index.put(config_.resolution_m);
  index.put(config_.clearing_distance_m);
  index.put(config_.pose_tolerance_m);
  index.put<std::int32_t>(config_.max_submaps);
  index.put(config_.max_memory_mb);
  index.put<std::uint64_t>(records_.size());
  std::set<std::string> listed;
  for (const SubmapEntry* entry : entries()) {
    const std::string bytes = entry->submap->to_bytes();
    const std::uint32_t sum = base::crc32(bytes.data(), bytes.size());
    const std::string name = file_name(entry->id, sum);
    write_atomically(directory + "/" + name, bytes);
    put_entry(*entry, sum, &index);
    listed.insert(name);
  }
  sync_directory(directory);
  write_atomically(directory + "/" + kIndexName, index.finish());
  sync_directory(directory);
  remove_unlisted(directory, listed);
}

SubmapCollection SubmapCollection::load(const std::string& directory, std::vector<std::string>* problems) {
  const std::string index_bytes = read_file(directory + "/" + kIndexName);
  base::ByteReader in(index_bytes, directory + "/" + kIndexName);
  if (in.get<std::uint32_t>() != kMagic) in.fail("is not a voxnav map index");
  if (in.get<std::uint32_t>() != kVersion) in.fail("has a version this program does not know");
  SubmapCollection out(get_config(&in));
  const std::uint64_t count = in.get_count(sizeof(std::uint32_t));
  for (std::uint64_t i = 0; i < count; ++i) {
    std::uint32_t sum = 0;
    SubmapEntry entry = get_entry(&in, &sum);
    const std::string path = directory + "/" + file_name(entry.id, sum);
    try {
      entry.submap = Submap::from_bytes(read_file(path));
      out.add(std::move(entry));
    } catch (const std::exception& error) {
      const std::string problem = path + ": " + error.what();
      if (!problems) throw std::invalid_argument(problem);
      problems->push_back(problem);
    }
  }
  return out;
}

}  // namespace voxnav::submap
