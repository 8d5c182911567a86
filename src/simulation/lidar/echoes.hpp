// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>

#include "voxnav_simulation/scene.hpp"

namespace voxnav_simulation {

/// What one beam gets back from surfaces that its pulse cannot tell apart.
struct Echo {
  float range_m;               ///< mean over the surfaces, weighted by their light: a mixed return lies between them
  float power;                 ///< photons that would return from a range of 1 m
  SurfaceClass surface_class;  ///< of the surface that returns most of the light
};

/// One ray of a footprint that met a surface.
struct RayReturn {
  float range_m;
  float power;  ///< photons from a range of 1 m, if all light of the beam met this surface
  SurfaceClass surface_class;
};

/// Returns the strongest echo of the rays of one footprint, as a LiDAR with one return per beam reports it, or nothing
/// when no ray met a surface. Surfaces belong to one echo as long as each follows the one before within `separation_m`:
/// pulses that overlap by half of their width merge. Sorts `returns` by range.
/// Source: Wagner et al., "Gaussian decomposition and calibration of a novel small-footprint full-waveform digitising
/// airborne laser scanner", ISPRS Journal 2006, section 3; the name mixed pixel is of Hebert and Krotkov, "3D
/// measurements from imaging laser radars", Image and Vision Computing 1992.
/// @param num_rays  rays of the footprint, those without a surface included
std::optional<Echo> strongest_echo(RayReturn* returns, std::size_t num_returns, std::size_t num_rays,
                                   float separation_m);

}  // namespace voxnav_simulation
