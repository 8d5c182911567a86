// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

namespace voxnav_simulation {

/// The class of the object to which a triangle belongs; quality metrics are computed for each class.
enum class SurfaceClass : std::uint8_t {
  kTerrain = 0,
  kTrunk = 1,
  kPole = 2,
  kFoliage = 3,  ///< leaves and bushes
  kBranch = 4,
  kRock = 5,
  kBuilding = 6,  ///< walls and houses
  kVehicle = 7,
  kPerson = 8,
  kFlyer = 9,  ///< another UAV
};
inline constexpr int kNumSurfaceClasses = 10;

const char* name_of(SurfaceClass surface_class);

/// The reflectance of a class for a laser beam (near infrared, 865 nm), and its colour.
struct Material {
  double reflectance;  ///< share of the light that comes back at normal incidence, 0 to 1
  std::array<std::uint8_t, 3> rgb;
};
const Material& material_of(SurfaceClass surface_class);

}  // namespace voxnav_simulation
