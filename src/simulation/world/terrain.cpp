// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/terrain.hpp"

#include <cmath>

#include "streams.hpp"
#include "voxnav_simulation/random.hpp"

namespace voxnav_simulation {
namespace {

/// One undulation of the ground: amplitude * sin(k . p + phase).
struct Wave {
  double amplitude_m;
  double kx, ky;
  double phase_rad;

  double at(double x, double y) const { return amplitude_m * std::sin(kx * x + ky * y + phase_rad); }
};

/// Returns waves whose amplitude is proportional to their length, so that their slopes are alike, and whose sum has the
/// configured standard deviation.
std::vector<Wave> make_waves(const WorldConfig& config, Rng* rng) {
  constexpr int kNumWaves = 10;
  std::vector<Wave> waves;
  double power = 0.0;
  for (int i = 0; i < kNumWaves; ++i) {
    const double wavelength = config.terrain_wavelength_m * rng->uniform(0.25, 1.0);
    const double direction = rng->uniform(0.0, 2.0 * M_PI);
    const double k = 2.0 * M_PI / wavelength;
    waves.push_back({wavelength, k * std::cos(direction), k * std::sin(direction), rng->uniform(0.0, 2.0 * M_PI)});
    power += 0.5 * wavelength * wavelength;
  }
  for (Wave& wave : waves) wave.amplitude_m *= config.terrain_amplitude_m / std::sqrt(power);
  return waves;
}

int num_vertices(double length_m, double cell_m) { return static_cast<int>(std::ceil(length_m / cell_m - 1e-9)) + 1; }

}  // namespace

Terrain::Terrain(const WorldConfig& config, std::uint64_t seed)
    : min_x_(config.min_corner_m[0] - config.terrain_margin_m),
      min_y_(config.min_corner_m[1] - config.terrain_margin_m),
      cell_m_(config.terrain_cell_m),
      num_x_(num_vertices(config.size_m[0] + 2 * config.terrain_margin_m, cell_m_)),
      num_y_(num_vertices(config.size_m[1] + 2 * config.terrain_margin_m, cell_m_)) {
  Rng rng(seed, kTerrainStream);
  const std::vector<Wave> waves = make_waves(config, &rng);
  heights_.reserve(static_cast<std::size_t>(num_x_) * num_y_);
  for (int iy = 0; iy < num_y_; ++iy) {
    for (int ix = 0; ix < num_x_; ++ix) {
      double height = config.terrain_roughness_m * rng.normal();
      for (const Wave& wave : waves) height += wave.at(min_x_ + ix * cell_m_, min_y_ + iy * cell_m_);
      heights_.push_back(height);
    }
  }
  const double start_height = height(config.start_m[0], config.start_m[1]).value();
  for (double& h : heights_) h -= start_height;
}

std::optional<double> Terrain::height(double x, double y) const {
  const double gx = (x - min_x_) / cell_m_, gy = (y - min_y_) / cell_m_;
  // The comparison is negated as a whole, so that NaN counts as outside.
  if (!(gx >= 0.0 && gy >= 0.0 && gx <= num_x_ - 1 && gy <= num_y_ - 1)) return std::nullopt;
  const int ix = std::min(static_cast<int>(gx), num_x_ - 2), iy = std::min(static_cast<int>(gy), num_y_ - 2);
  const double u = gx - ix, v = gy - iy;
  const double h00 = vertex_height(ix, iy), h11 = vertex_height(ix + 1, iy + 1);
  if (u >= v) {
    const double h10 = vertex_height(ix + 1, iy);
    return h00 + u * (h10 - h00) + v * (h11 - h10);
  }
  const double h01 = vertex_height(ix, iy + 1);
  return h00 + v * (h01 - h00) + u * (h11 - h01);
}

void Terrain::append_to(WorldMesh* mesh) const {
  const auto first = static_cast<std::uint32_t>(mesh->vertices.size());
  for (int iy = 0; iy < num_y_; ++iy) {
    for (int ix = 0; ix < num_x_; ++ix) {
      mesh->add_vertex({min_x_ + ix * cell_m_, min_y_ + iy * cell_m_, vertex_height(ix, iy)});
    }
  }
  for (int iy = 0; iy + 1 < num_y_; ++iy) {
    for (int ix = 0; ix + 1 < num_x_; ++ix) {
      const std::uint32_t a = first + static_cast<std::uint32_t>(iy * num_x_ + ix);
      const std::uint32_t b = a + static_cast<std::uint32_t>(num_x_);
      mesh->add_triangle(a, a + 1, b + 1, SurfaceClass::kTerrain);
      mesh->add_triangle(a, b + 1, b, SurfaceClass::kTerrain);
    }
  }
}

}  // namespace voxnav_simulation
