// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <stdexcept>

#include "occupancy/octomap_file.hpp"

namespace voxnav::occupancy {
namespace {

constexpr const char* kFullFile = "# Octomap OcTree file";
constexpr const char* kBinaryFile = "# Octomap OcTree binary file";
constexpr const char* kShiftComment = "# shift_voxels ";
constexpr const char* kLastLine = "data";
constexpr const char* kTreeType = "OcTree";
constexpr int kDepth = 16;                                      // levels of an OctoMap below its root
constexpr std::int64_t kReach = 1 << 15;                        // voxels on each side of its origin
constexpr float kFreeLogOdds = -2.0f, kOccupiedLogOdds = 3.5f;  // of the binary form, as OctoMap reads it

using Voxel = std::array<std::int64_t, 3>;

struct Header {
  bool is_binary = false;
  std::size_t num_nodes = 0;
  double resolution_m = 0.0;
  geometry::Index3 shift;
};

/// Reads the values of a line, or throws naming the line.
template <class... Values>
void read_values(const std::string& line, std::size_t from, Values*... values) {
  std::istringstream words(line.substr(std::min(from, line.size())));
  if (!(words >> ... >> *values)) throw std::runtime_error("bad line in its header: " + line);
}

/// The lines of a header by their first word, up to the line `data`. Comments are left out, but for that of a shift.
std::map<std::string, std::string> header_lines(std::istream* in) {
  std::map<std::string, std::string> out;
  std::string line;
  while (std::getline(*in, line) && line != kLastLine) {
    const bool is_comment = !line.empty() && line[0] == '#';
    if (line.rfind(kShiftComment, 0) == 0) out[kShiftComment] = line;
    if (!is_comment) out[line.substr(0, line.find(' '))] = line;
  }
  return out;
}

Header read_header(std::istream* in) {
  Header out;
  std::string line;
  std::getline(*in, line);
  out.is_binary = line.rfind(kBinaryFile, 0) == 0;
  if (!out.is_binary && line.rfind(kFullFile, 0) != 0) throw std::runtime_error("it is no file of OctoMap");
  std::map<std::string, std::string> lines = header_lines(in);
  std::string type;
  if (lines.count("id") != 0) read_values(lines["id"], 2, &type);
  if (type != kTreeType) throw std::runtime_error("it holds a tree of the type '" + type + "', not an OcTree");
  if (lines.count("res") != 0) read_values(lines["res"], 3, &out.resolution_m);
  if (!(out.resolution_m > 0.0) || !std::isfinite(out.resolution_m)) throw std::runtime_error("it has no resolution");
  read_values(lines["size"], 4, &out.num_nodes);
  if (lines.count(kShiftComment) != 0) {
    read_values(lines[kShiftComment], std::strlen(kShiftComment), &out.shift.x, &out.shift.y, &out.shift.z);
  }
  return out;
}

/// Reads nodes depth first, as they are written.
class NodeReader {
 public:
  NodeReader(std::string bytes, const geometry::Index3& shift) : bytes_(std::move(bytes)), shift_(shift) {}

  void read_full(int depth, const Voxel& low) {
    const char* node = take(sizeof(float) + 1);
    float log_odds = 0.0f;
    std::memcpy(&log_odds, node, sizeof(float));
    const auto present = static_cast<std::uint8_t>(node[sizeof(float)]);
    if (present == 0) return add(depth, low, log_odds);
    check_depth(depth);
    for (int child = 0; child < 8; ++child) {
      if ((present >> child & 1) != 0) read_full(depth + 1, child_of(depth, low, child));
    }
  }

  void read_binary(int depth, const Voxel& low) {
    const char* node = take(2);
    check_depth(depth);
    const unsigned kinds =
        static_cast<std::uint8_t>(node[0]) | static_cast<unsigned>(static_cast<std::uint8_t>(node[1])) << 8;
    if (kinds == 0) return add(depth, low, kOccupiedLogOdds);  // as OctoMap reads a node without children
    for (int child = 0; child < 8; ++child) {
      const unsigned kind = kinds >> (2 * child) & 3U;
      if (kind == 0) continue;
      const Voxel at = child_of(depth, low, child);
      if (kind == 3) {
        read_binary(depth + 1, at);
      } else {
        ++num_nodes_;
        add(depth + 1, at, kind == 2 ? kOccupiedLogOdds : kFreeLogOdds);
      }
    }
  }

  std::vector<OctomapLeaf> finish(std::size_t num_nodes) {
    if (at_ != bytes_.size() || num_nodes_ != num_nodes) {
      throw std::runtime_error("it announces " + std::to_string(num_nodes) + " nodes and holds " +
                               std::to_string(num_nodes_) + ", with " + std::to_string(bytes_.size() - at_) +
                               " bytes after them");
    }
    return std::move(leaves_);
  }

 private:
  static std::int64_t side_of(int depth) { return std::int64_t{1} << (kDepth - depth); }

  static Voxel child_of(int depth, const Voxel& low, int child) {
    const std::int64_t half = side_of(depth + 1);
    return {low[0] + half * (child & 1), low[1] + half * (child >> 1 & 1), low[2] + half * (child >> 2)};
  }

  static void check_depth(int depth) {
    if (depth >= kDepth) throw std::runtime_error("it has nodes below the voxels");
  }

  const char* take(std::size_t count) {
    if (bytes_.size() - at_ < count) throw std::runtime_error("it ends in the middle of its nodes");
    ++num_nodes_;
    at_ += count;
    return &bytes_[at_ - count];
  }

  void add(int depth, const Voxel& low, float log_odds) {
    leaves_.push_back({{low[0] + shift_.x, low[1] + shift_.y, low[2] + shift_.z}, side_of(depth), log_odds});
  }

  std::string bytes_;
  geometry::Index3 shift_;
  std::size_t at_ = 0, num_nodes_ = 0;
  std::vector<OctomapLeaf> leaves_;
};

OctomapFile read_octomap(std::istream* in) {
  const Header header = read_header(in);
  OctomapFile out;
  out.resolution_m = header.resolution_m;
  NodeReader reader({std::istreambuf_iterator<char>(*in), {}}, header.shift);
  if (header.num_nodes > 0) {
    const Voxel low{-kReach, -kReach, -kReach};
    header.is_binary ? reader.read_binary(0, low) : reader.read_full(0, low);
  }
  out.leaves = reader.finish(header.num_nodes);
  return out;
}

}  // namespace

OctomapFile read_octomap(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read an OcTree from " + path + ": the file cannot be opened");
  try {
    return read_octomap(&file);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error("cannot read an OcTree from " + path + ": " + error.what());
  }
}

}  // namespace voxnav::occupancy
