// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/mesh.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <unordered_map>

#include "voxnav/base/ply.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::Vec3f;

/// Corners of each face of a cube, counter-clockwise seen from outside; corner bits are x, y, z.
constexpr int kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};

/// An edge of the cube: 3 * lower corner + axis.
int edge_of(int a, int b) {
  const int axis = (a ^ b) == 1 ? 0 : (a ^ b) == 2 ? 1 : 2;
  return 3 * (a & b) + axis;
}

constexpr int kNoEdge = -1;
using NextEdge = std::array<int, 24>;

/// For every crossed edge the one that follows it around its polygon.
NextEdge trace_faces(const std::array<bool, 8>& is_inside) {
  NextEdge next;
  next.fill(kNoEdge);
  for (const auto& face : kFaces) {
    int into[4];  // edges crossed on the way in, and their place around the face
    int out_of[4];
    for (int i = 0; i < 4; ++i) {
      const int a = face[i];
      const int b = face[(i + 1) % 4];
      out_of[i] = is_inside[a] && !is_inside[b] ? edge_of(a, b) : kNoEdge;
      into[i] = !is_inside[a] && is_inside[b] ? edge_of(a, b) : kNoEdge;
    }
    for (int i = 0; i < 4; ++i) {
      if (out_of[i] == kNoEdge) continue;
      // The crossing before it: the line cuts off the inside corners between both.
      for (int back = 1; back < 4; ++back) {
        const int edge = into[(i + 4 - back) % 4];
        if (edge == kNoEdge) continue;
        next[edge] = out_of[i];
        break;
      }
    }
  }
  return next;
}

struct VertexKey {
  Index3 voxel;
  int axis;
  friend bool operator==(const VertexKey& a, const VertexKey& b) { return a.voxel == b.voxel && a.axis == b.axis; }
};
struct VertexKeyHash {
  std::size_t operator()(const VertexKey& k) const {
    return geometry::Index3Hash{}(k.voxel) * 3 + static_cast<std::size_t>(k.axis);
  }
};

class Extractor {
 public:
  /// @param T_A_G frame of the voxels in that of the mesh
  Extractor(const geometry::Pose& T_A_G, double resolution_m, Mesh* mesh)
      : T_A_G_(T_A_G), resolution_m_(resolution_m), mesh_(mesh) {}

  /// Cubes of one block, until the mesh has `max_triangles`.
  void add_block(const Index3& block, const DistanceBlock& distances, std::size_t max_triangles) {
    std::array<float, 8> values;
    for (int offset = 0; offset < geometry::kBlockVolume && mesh_->triangles.size() < max_triangles; ++offset) {
      const Index3 local = geometry::voxel_at({0, 0, 0}, offset);
      if (distances.corners(local.x, local.y, local.z, &values)) add_cube(geometry::voxel_at(block, offset), values);
    }
  }

 private:
  void add_cube(const Index3& lower, const std::array<float, 8>& values) {
    std::array<bool, 8> is_inside;
    int num_inside = 0;
    for (int i = 0; i < 8; ++i) num_inside += is_inside[i] = values[i] < 0.f;
    if (num_inside == 0 || num_inside == 8) return;
    NextEdge next = trace_faces(is_inside);
    for (int start = 0; start < 24; ++start) {
      if (next[start] == kNoEdge) continue;
      polygon_.clear();
      for (int edge = start; next[edge] != kNoEdge;) {
        polygon_.push_back(vertex(lower, edge, values));
        const int following = next[edge];
        next[edge] = kNoEdge;
        edge = following;
      }
      for (std::size_t i = 2; i < polygon_.size(); ++i) {
        mesh_->triangles.push_back({polygon_[0], polygon_[i - 1], polygon_[i]});
      }
    }
  }

  std::uint32_t vertex(const Index3& lower, int edge, const std::array<float, 8>& values) {
    const int corner = edge / 3;
    const int axis = edge % 3;
    const Index3 voxel = lower + Index3{corner & 1, (corner >> 1) & 1, corner >> 2};
    const auto inserted = vertices_.try_emplace({voxel, axis}, static_cast<std::uint32_t>(mesh_->vertices.size()));
    if (inserted.second) {
      const float a = values[static_cast<std::size_t>(corner)];
      const float b = values[static_cast<std::size_t>(corner | (1 << axis))];
      geometry::Vec3 p(voxel.x + 0.5, voxel.y + 0.5, voxel.z + 0.5);
      p[axis] += a / (a - b);
      mesh_->vertices.push_back((T_A_G_ * (p * resolution_m_)).cast<float>());
    }
    return inserted.first->second;
  }

  geometry::Pose T_A_G_;
  double resolution_m_;
  Mesh* mesh_;
  std::vector<std::uint32_t> polygon_;
  std::unordered_map<VertexKey, std::uint32_t, VertexKeyHash> vertices_;
};

/// The merged map around some blocks, as one submap would hold it.
CompressedField field_around(const EvidenceMap& evidence, const std::vector<Index3>& blocks) {
  std::set<Index3> around;
  for (const Index3& block : blocks) {
    for (int i = 0; i < 27; ++i) around.insert(block + Index3{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1});
  }
  occupancy::MapContent content;
  content.resolution_m = evidence.resolution_m();
  for (const Index3& index : around) {
    const EvidenceBlock* known = evidence.find(index);
    if (!known) continue;
    occupancy::ContentBlock block{index, to_states(known->states), {}};
    for (const EvidenceLeaf& leaf : known->leaves) block.occupied.push_back({leaf.offset, leaf.mean, leaf.hits});
    auto& leaves = block.occupied;
    std::stable_sort(leaves.begin(), leaves.end(), [](const auto& a, const auto& b) { return a.offset < b.offset; });
    const auto is_same = [](const auto& a, const auto& b) { return a.offset == b.offset; };
    leaves.erase(std::unique(leaves.begin(), leaves.end(), is_same), leaves.end());
    content.blocks.push_back(std::move(block));
  }
  return CompressedField(content, SubmapConfig{}.band_voxels);
}

}  // namespace

void Mesh::append(const Mesh& other) {
  const auto base = static_cast<std::uint32_t>(vertices.size());
  vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
  colors.insert(colors.end(), other.colors.begin(), other.colors.end());
  for (const auto& t : other.triangles) triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
}

Mesh extract_mesh(const Submap& submap, std::size_t max_triangles) {
  Mesh mesh;
  Extractor extractor(submap.T_S_G(), submap.resolution_m(), &mesh);
  const auto field = submap.field();
  for (std::size_t i = 0; i < field->num_blocks(); ++i) {
    extractor.add_block(field->block_index(i), *submap.distances(*field, static_cast<int>(i)), max_triangles);
  }
  return mesh;
}

Mesh extract_mesh(const EvidenceMap& evidence, const std::vector<Index3>& blocks, std::size_t max_triangles) {
  Mesh mesh;
  Extractor extractor(geometry::Pose::Identity(), evidence.resolution_m(), &mesh);
  const CompressedField field = field_around(evidence, blocks);
  for (const Index3& block : blocks) {
    const auto distances = derive_distances(field, block);
    if (distances) extractor.add_block(block, *distances, max_triangles);
  }
  for (const Vec3f& p : mesh.vertices) mesh.colors.push_back(color_of_height(p.z()));
  return mesh;
}

Mesh extract_mesh(SubmapCollection* collection, std::size_t max_triangles) {
  constexpr std::size_t kAtOnce = 64;  // bounds what is unpacked at a time
  collection->update();
  const EvidenceMap& evidence = collection->evidence();
  std::vector<Index3> order;
  for (const auto& item : evidence.blocks()) order.push_back(item.first);
  std::sort(order.begin(), order.end());
  Mesh out;
  for (std::size_t i = 0; i < order.size() && out.triangles.size() < max_triangles; i += kAtOnce) {
    const std::vector<Index3> some(order.begin() + static_cast<std::ptrdiff_t>(i),
                                   order.begin() + static_cast<std::ptrdiff_t>(std::min(order.size(), i + kAtOnce)));
    out.append(extract_mesh(evidence, some, max_triangles - out.triangles.size()));
  }
  return out;
}

Color color_of_height(double z_m, const HeightScale& scale) {
  const double share = std::clamp((z_m - scale.min_m) / (scale.max_m - scale.min_m), 0.0, 1.0);
  const double hue = 5.0 * share;  // 0 = red, 2 = green, 4 = blue, 5 = magenta
  Color out;
  for (int k = 0; k < 3; ++k) {
    const double distance = std::abs(std::fmod(hue + 6.0 - 2.0 * k, 6.0) - 3.0);
    out[static_cast<std::size_t>(k)] =
        static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(distance - 1.0, 0.0, 1.0)));
  }
  return out;
}

Color color_of(std::uint32_t submap_id) {
  // Golden-ratio steps around the hue circle.
  const double hue = std::fmod(0.61803398875 * submap_id, 1.0) * 6.0;
  Color out;
  for (int k = 0; k < 3; ++k) {
    const double distance = std::abs(std::fmod(hue + 6.0 - 2.0 * k, 6.0) - 3.0);
    out[static_cast<std::size_t>(k)] =
        static_cast<std::uint8_t>(255.0 * (0.25 + 0.7 * std::min(1.0, std::max(0.0, distance - 1.0))));
  }
  return out;
}

std::string to_ply(const Mesh& mesh) {
  const bool has_colors = mesh.colors.size() == mesh.vertices.size() && !mesh.colors.empty();
  base::PlyWriter out;
  if (has_colors) {
    out.element("vertex", mesh.vertices.size(),
                {"float x", "float y", "float z", "uchar red", "uchar green", "uchar blue"});
  } else {
    out.element("vertex", mesh.vertices.size(), {"float x", "float y", "float z"});
  }
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    out.put_raw(mesh.vertices[i].data(), 3 * sizeof(float));
    if (has_colors) out.put(mesh.colors[i]);
  }
  out.element("face", mesh.triangles.size(), {"list uchar uint vertex_indices"});
  for (const auto& triangle : mesh.triangles) {
    out.put<std::uint8_t>(3);
    out.put(triangle);
  }
  return out.finish();
}

}  // namespace voxnav::submap
