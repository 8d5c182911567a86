// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <embree3/rtcore.h>

#include <memory>
#include <optional>

#include "voxnav_simulation/scene.hpp"

namespace voxnav_simulation {

/// Embree's device, which all parts of a scene share.
struct Scene::Device {
  Device();
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  RTCDevice handle;
};

/// One mesh with its search tree, which never changes after construction. `mesh` must outlive it.
struct Scene::Part {
  Part(std::shared_ptr<Device> device_in, const WorldMesh& mesh_in, const Pose& T_W_mesh);
  ~Part();
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;

  /// Casts the valid lanes up to their present far end. Rays of the first `count` lanes that hit a surface are
  /// shortened to it, and their hits are written.
  void cast(RTCRayHit8* packet, const int* valid, Hit* hits, std::size_t count) const;
  std::optional<Nearest> nearest(const Vec3& p, double max_m) const;

  std::shared_ptr<Device> device;
  const WorldMesh* mesh;
  Pose T_W_part;
  RTCScene scene;
  RTCGeometry geometry;
  const float* vertices;  ///< the buffer that Embree owns, in W
};

}  // namespace voxnav_simulation
