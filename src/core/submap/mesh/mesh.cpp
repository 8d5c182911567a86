// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/mesh.hpp"

#include <algorithm>
#include <cmath>

#include "voxnav/base/ply.hpp"

namespace voxnav::submap {
namespace {

/// Returns red, green and blue, each from 0 to 1, of the fully saturated colour with a hue from 0 to 6: 0 red, 2 green,
/// 4 blue.
std::array<double, 3> rgb_of_hue(double hue) {
  std::array<double, 3> out;
  for (int k = 0; k < 3; ++k) {
    const double distance = std::abs(std::fmod(hue + 6.0 - 2.0 * k, 6.0) - 3.0);
    out[static_cast<std::size_t>(k)] = std::clamp(distance - 1.0, 0.0, 1.0);
  }
  return out;
}

}  // namespace

void Mesh::append(const Mesh& other) {
  const auto base = static_cast<std::uint32_t>(vertices.size());
  vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
  colors.insert(colors.end(), other.colors.begin(), other.colors.end());
  for (const auto& t : other.triangles) triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
}

Color color_of_height(double z_m, const HeightScale& scale) {
  const double share = std::clamp((z_m - scale.min_m) / (scale.max_m - scale.min_m), 0.0, 1.0);
  const std::array<double, 3> rgb = rgb_of_hue(5.0 * share);  // from red to magenta
  Color out;
  for (std::size_t k = 0; k < 3; ++k) out[k] = static_cast<std::uint8_t>(std::lround(255.0 * rgb[k]));
  return out;
}

Color color_of(std::uint32_t submap_id) {
  // Golden-ratio steps around the hue circle.
  const std::array<double, 3> rgb = rgb_of_hue(std::fmod(0.61803398875 * submap_id, 1.0) * 6.0);
  Color out;
  for (std::size_t k = 0; k < 3; ++k) out[k] = static_cast<std::uint8_t>(255.0 * (0.25 + 0.7 * rgb[k]));
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
