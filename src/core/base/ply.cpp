// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/base/ply.hpp"

#include <fstream>
#include <stdexcept>
#include <utility>

namespace voxnav::base {

void PlyWriter::element(const std::string& name, std::size_t count, std::initializer_list<const char*> properties) {
  header_ += "element " + name + " " + std::to_string(count) + "\n";
  for (const char* property : properties) header_ += std::string("property ") + property + "\n";
}

std::string PlyWriter::finish() {
  std::string out = "ply\nformat binary_little_endian 1.0\n" + std::exchange(header_, {}) + "end_header\n";
  out += std::exchange(rows_, {});
  return out;
}

void PlyWriter::save(const std::string& path) {
  const std::string bytes = finish();
  std::ofstream out(path, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace voxnav::base
