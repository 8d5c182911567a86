// SPDX-License-Identifier: BSD-3-Clause
#include "submap/files/map_files.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace voxnav::submap {
namespace {

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

}  // namespace

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

void remove_unlisted(const std::string& directory, const std::set<std::string>& listed) {
  DIR* handle = ::opendir(directory.c_str());
  if (!handle) return;
  while (const dirent* item = ::readdir(handle)) {
    const std::string name = item->d_name;
    if (name.compare(0, 7, "submap_") == 0 && listed.count(name) == 0) ::unlink((directory + "/" + name).c_str());
  }
  ::closedir(handle);
}

}  // namespace voxnav::submap
