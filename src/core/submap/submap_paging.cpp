// SPDX-License-Identifier: BSD-3-Clause
// Moving the content of a submap to disk and back, so that a long flight does not fill the memory.
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "submap/content/submap_content.hpp"
#include "voxnav/submap/submap.hpp"

namespace voxnav::submap {

void Submap::page_out(const std::string& path) const {
  if (!is_resident()) return;
  const std::string bytes = page_path_.empty() ? to_bytes() : std::string();
  const std::lock_guard<std::mutex> lock(mutex_);
  if (page_path_.empty()) {
    std::ofstream out(path, std::ios::binary | std::ios::trunc);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!out.flush()) throw std::runtime_error(path + ": cannot be written");
    page_path_ = path;
  }
  std::atomic_store(&content_, std::shared_ptr<const SubmapContent>());
}

std::shared_ptr<const SubmapContent> Submap::content() const {
  auto held = std::atomic_load(&content_);
  if (held) return held;
  const std::lock_guard<std::mutex> lock(mutex_);
  held = std::atomic_load(&content_);
  if (held) return held;
  std::ifstream in(page_path_, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  try {
    held = std::atomic_load(&from_bytes(bytes)->content_);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(page_path_ + ": cannot be read back: " + error.what());
  }
  std::atomic_store(&content_, held);
  return held;
}

}  // namespace voxnav::submap
