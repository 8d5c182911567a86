// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/base/ply.hpp"

#include "voxnav_simulation/mesh.hpp"

namespace voxnav_simulation {

void save_ply(const WorldMesh& mesh, const std::vector<std::string>& comments, const std::string& path) {
  voxnav::base::PlyWriter out;
  for (const std::string& comment : comments) out.comment(comment);
  for (int i = 0; i < kNumSurfaceClasses; ++i) {
    out.comment("class " + std::to_string(i) + " " + name_of(static_cast<SurfaceClass>(i)));
  }
  out.element("vertex", mesh.vertices.size(), {"float x", "float y", "float z"});
  for (const Vec3f& vertex : mesh.vertices) out.put_raw(vertex.data(), 3 * sizeof(float));
  out.element("face", mesh.triangles.size(),
              {"list uchar int vertex_indices", "uchar class", "uchar red", "uchar green", "uchar blue"});
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    out.put<std::uint8_t>(3);
    out.put(mesh.triangles[i]);
    out.put(static_cast<std::uint8_t>(mesh.classes[i]));
    out.put(material_of(mesh.classes[i]).rgb);
  }
  out.save(path);
}

}  // namespace voxnav_simulation
