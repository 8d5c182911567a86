// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <stdexcept>

#include "voxnav_simulation/mesh.hpp"

namespace voxnav_simulation {
namespace {

void write_header(std::ostream& out, const Mesh& mesh, const std::vector<std::string>& comments) {
  out << "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& comment : comments) out << "comment " << comment << "\n";
  for (int i = 0; i < kNumSurfaceClasses; ++i) {
    out << "comment class " << i << " " << name_of(static_cast<SurfaceClass>(i)) << "\n";
  }
  out << "element vertex " << mesh.vertices.size() << "\nproperty float x\nproperty float y\nproperty float z\n"
      << "element face " << mesh.triangles.size() << "\nproperty list uchar int vertex_indices\n"
      << "property uchar class\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
}

void write_faces(std::ostream& out, const Mesh& mesh) {
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& rgb = material_of(mesh.classes[i]).rgb;
    const std::array<std::uint8_t, 4> tail{static_cast<std::uint8_t>(mesh.classes[i]), rgb[0], rgb[1], rgb[2]};
    out.put(3);
    out.write(reinterpret_cast<const char*>(mesh.triangles[i].data()), sizeof(mesh.triangles[i]));
    out.write(reinterpret_cast<const char*>(tail.data()), tail.size());
  }
}

}  // namespace

void save_ply(const Mesh& mesh, const std::vector<std::string>& comments, const std::string& path) {
  static_assert(sizeof(Vec3f) == 12, "vertices are written as they lie in memory");
  std::ofstream out(path, std::ios::binary);
  write_header(out, mesh, comments);
  out.write(reinterpret_cast<const char*>(mesh.vertices.data()),
            static_cast<std::streamsize>(mesh.vertices.size() * sizeof(Vec3f)));
  write_faces(out, mesh);
  out.flush();
  if (!out) throw std::runtime_error("cannot write " + path);
}

}  // namespace voxnav_simulation
