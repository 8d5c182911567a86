// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/materials.hpp"

namespace voxnav_simulation {
namespace {

struct Entry {
  const char* name;
  Material material;
};

// Leaves are bright in the near infrared, because chlorophyll does not absorb it; bark and soil are dark.
constexpr std::array<Entry, kNumSurfaceClasses> kEntries{{
    {"terrain", {0.30, {124, 104, 70}}},
    {"trunk", {0.25, {92, 64, 40}}},
    {"pole", {0.45, {150, 150, 155}}},
    {"foliage", {0.55, {58, 120, 44}}},
    {"branch", {0.25, {104, 78, 50}}},
    {"rock", {0.35, {128, 128, 124}}},
    {"building", {0.50, {196, 180, 160}}},
    {"vehicle", {0.60, {190, 32, 28}}},
    {"person", {0.40, {230, 140, 40}}},
    {"flyer", {0.20, {40, 60, 160}}},
}};

}  // namespace

const char* name_of(SurfaceClass surface_class) { return kEntries[static_cast<std::size_t>(surface_class)].name; }

const Material& material_of(SurfaceClass surface_class) {
  return kEntries[static_cast<std::size_t>(surface_class)].material;
}

}  // namespace voxnav_simulation
