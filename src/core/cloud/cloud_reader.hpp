// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstring>

#include "voxnav/cloud/cloud_layout.hpp"

namespace voxnav::cloud {

inline float load_float(const std::uint8_t* bytes) {
  float value;
  std::memcpy(&value, bytes, sizeof(value));
  return value;
}

/// Coordinates and intensity are float32, as in nearly every driver.
struct Float32Reader {
  explicit Float32Reader(const CloudAccess& a)
      : x(a.x.offset),
        y(a.y.offset),
        z(a.z.offset),
        i(a.intensity ? a.intensity->offset : a.x.offset),
        scale(a.intensity ? 1.0F : 0.0F) {}
  static bool can_read(const CloudAccess& a) {
    const FieldType f32 = FieldType::kFloat32;
    return a.x.type == f32 && a.y.type == f32 && a.z.type == f32 && (!a.intensity || a.intensity->type == f32);
  }
  void position(const std::uint8_t* p, float* out) const {
    out[0] = load_float(p + x);
    out[1] = load_float(p + y);
    out[2] = load_float(p + z);
  }
  float intensity(const std::uint8_t* p) const { return load_float(p + i) * scale; }

  std::uint32_t x, y, z, i;
  float scale;  // 0 without intensity field: the load then hits x, which is finite where this is asked
};

/// Any types.
struct AnyReader {
  explicit AnyReader(const CloudAccess& a) : access(a) {}
  void position(const std::uint8_t* p, float* out) const {
    out[0] = static_cast<float>(read_number(p, access.x));
    out[1] = static_cast<float>(read_number(p, access.y));
    out[2] = static_cast<float>(read_number(p, access.z));
  }
  float intensity(const std::uint8_t* p) const {
    return access.intensity ? static_cast<float>(read_number(p, *access.intensity)) : 0.0F;
  }
  CloudAccess access;
};

/// Point times as nanoseconds after the cloud's stamp, with the least of them.
class TimeReader {
 public:
  /// No LiDAR sweeps slower than this; larger offsets are another clock or garbage.
  static constexpr std::int64_t kMaxOffsetNs = 1'000'000'000;

  TimeReader(const CloudAccess& access, base::StampNs stamp_ns) : access_(access), stamp_ns_(stamp_ns) {
    is_uint32_ = access.time && access.time->type == FieldType::kUint32;
    offset_ = access.time ? access.time->offset : 0;
  }
  /// Offset of one point; two's complement when negative (fixed by the caller with min_ns()).
  std::uint32_t operator()(const std::uint8_t* point) {
    if (is_uint32_) {
      std::uint32_t value;
      std::memcpy(&value, point + offset_, sizeof(value));
      if (value <= kMaxOffsetNs) return value;
      ++num_bad_;
      return 0;
    }
    return access_.time ? slow(point) : 0;
  }
  std::int64_t min_ns() const { return min_ns_; }
  std::uint64_t num_bad() const { return num_bad_; }

 private:
  std::uint32_t slow(const std::uint8_t* point) {
    double ns = read_number(point, *access_.time);
    if (access_.time_unit == TimeUnit::kSecondsAbsolute) ns -= static_cast<double>(stamp_ns_) * 1e-9;
    if (access_.time_unit != TimeUnit::kNanosecondsAfterStamp) ns *= 1e9;
    if (!(std::abs(ns) <= static_cast<double>(kMaxOffsetNs))) {
      ++num_bad_;
      return 0;
    }
    const std::int64_t offset = std::llround(ns);
    min_ns_ = offset < min_ns_ ? offset : min_ns_;
    return static_cast<std::uint32_t>(offset);
  }

  CloudAccess access_;
  base::StampNs stamp_ns_;
  bool is_uint32_ = false;
  std::uint32_t offset_ = 0;
  std::int64_t min_ns_ = 0;
  std::uint64_t num_bad_ = 0;
};

}  // namespace voxnav::cloud
