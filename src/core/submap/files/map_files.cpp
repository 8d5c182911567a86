// SPDX-License-Identifier: BSD-3-Clause
#include "submap/files/map_files.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>

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
  std::error_code error;
  std::filesystem::create_directories(path, error);
  // GCC 9 reports an error for a path that ends in a slash although the directory is there afterwards.
  std::error_code not_there;
  if (!std::filesystem::is_directory(path, not_there))
    throw std::runtime_error(path + ": cannot be created: " + (error ? error : not_there).message());
}

std::string read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error(path + ": cannot be read");
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void remove_unlisted(const std::string& directory, const std::set<std::string>& listed) {
  // A file that cannot be removed only takes up space, so errors are not reported.
  std::error_code error;
  for (std::filesystem::directory_iterator item(directory, error), end; !error && item != end; item.increment(error)) {
    const std::string name = item->path().filename().string();
    std::error_code ignored;
    if (name.compare(0, 7, "submap_") == 0 && listed.count(name) == 0) std::filesystem::remove(item->path(), ignored);
  }
}

}  // namespace voxnav::submap
