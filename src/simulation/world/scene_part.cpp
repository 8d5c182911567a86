// SPDX-License-Identifier: BSD-3-Clause
#include "scene_part.hpp"

#include <cmath>
#include <stdexcept>

namespace voxnav_simulation {
namespace {

void throw_on_error(RTCDevice device, const char* what) {
  const RTCError error = rtcGetDeviceError(device);
  if (error != RTC_ERROR_NONE) {
    throw std::runtime_error(std::string(what) + ": Embree error " + std::to_string(static_cast<int>(error)));
  }
}

void* new_buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, std::size_t item, std::size_t count) {
  void* buffer = rtcSetNewGeometryBuffer(geometry, type, 0, format, item, count);
  if (!buffer) throw std::runtime_error("Embree could not allocate a mesh buffer");
  return buffer;
}

RTCGeometry make_geometry(RTCDevice device, const WorldMesh& mesh, const Pose& T_W_mesh) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(
      new_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices.size()));
  for (const Vec3f& vertex : mesh.vertices) {
    const Vec3f moved = (T_W_mesh * vertex.cast<double>()).cast<float>();
    for (int i = 0; i < 3; ++i) *vertices++ = moved[i];
  }
  auto* indices = static_cast<std::uint32_t*>(
      new_buffer(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) *indices++ = corner;
  }
  rtcCommitGeometry(geometry);
  return geometry;
}

}  // namespace

// One thread builds the search tree, so that the result does not depend on the number of threads.
Scene::Device::Device() : handle(rtcNewDevice("threads=1,set_affinity=0")) {
  if (!handle) throw std::runtime_error("Embree device could not be created");
}

Scene::Device::~Device() { rtcReleaseDevice(handle); }

Scene::Part::Part(std::shared_ptr<Device> device_in, const WorldMesh& mesh_in, const Pose& T_W_mesh)
    : device(std::move(device_in)), mesh(&mesh_in), T_W_part(T_W_mesh), scene(rtcNewScene(device->handle)) {
  // In robust mode no ray passes through the edge between two triangles.
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  geometry = make_geometry(device->handle, mesh_in, T_W_mesh);
  vertices = static_cast<const float*>(rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0));
  rtcAttachGeometryByID(scene, geometry, 0);
  rtcCommitScene(scene);
  throw_on_error(device->handle, "building the search tree");
}

Scene::Part::~Part() {
  rtcReleaseGeometry(geometry);
  rtcReleaseScene(scene);
}

void Scene::Part::cast(RTCRayHit8* packet, const int* valid, Hit* hits, std::size_t count) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(valid, scene, &context, packet);
  for (std::size_t i = 0; i < count; ++i) {
    if (packet->hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    const Vec3f normal(packet->hit.Ng_x[i], packet->hit.Ng_y[i], packet->hit.Ng_z[i]);
    const Vec3f direction(packet->ray.dir_x[i], packet->ray.dir_y[i], packet->ray.dir_z[i]);
    const float cosine = std::abs(normal.dot(direction)) / std::max(normal.norm(), 1e-30F);
    hits[i] = {packet->ray.tfar[i], std::min(cosine, 1.0F), mesh->classes[packet->hit.primID[i]]};
    packet->hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;  // so that the next part only reports nearer hits
  }
}

std::optional<Nearest> Scene::Part::nearest(const Vec3& p, double max_m) const {
  struct Search {
    const Part* part;
    Vec3 point;
    std::optional<Nearest> best;
  } search{this, p, std::nullopt};
  RTCPointQuery query{static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()), 0.0F,
                      static_cast<float>(max_m)};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  const auto visit = [](RTCPointQueryFunctionArguments* args) {
    auto* s = static_cast<Search*>(args->userPtr);
    const auto& corners = s->part->mesh->triangles[args->primID];
    const auto corner = [&](int i) {
      return Vec3f(s->part->vertices + std::size_t{3} * corners[i]).cast<double>().eval();
    };
    const double distance = distance_to_triangle(s->point, corner(0), corner(1), corner(2));
    if (distance > static_cast<double>(args->query->radius)) return false;
    s->best = Nearest{distance, s->part->mesh->classes[args->primID]};
    args->query->radius = static_cast<float>(distance);
    return true;
  };
  rtcPointQuery(scene, &query, &context, visit, &search);
  return search.best;
}

}  // namespace voxnav_simulation
