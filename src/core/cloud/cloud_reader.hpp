// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstring>

#include "cloud/time_sample.hpp"
#include "voxnav/cloud/point_times.hpp"

namespace voxnav::cloud {

inline float load_float(const std::uint8_t* bytes) {
  float value;
  std::memcpy(&value, bytes, sizeof(value));
  return value;
}

/// Reads points whose coordinates and intensity are float32, as in nearly every driver.
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
  float scale;  // 0 without an intensity field: x is loaded instead, which is finite when this is called
};

/// Reads points of any types.
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

/// Reads point times as nanoseconds after the cloud's stamp, and remembers the least of them.
class TimeReader {
 public:
  TimeReader(const CloudAccess& access, const CloudTimes& times) : times_(times), last_ns_(0) {
    if (!access.time || times.tick_ns == 0.0) return;
    is_used_ = true;
    field_ = access.time->access;
    // As with Ouster, whose format is common, the numbers are the offsets themselves and need no conversion.
    is_direct_ = field_.type == FieldType::kUint32 && times.tick_ns == 1.0 && times.zero == 0.0 && times.first_ns <= 0;
    if (is_direct_) last_ns_ = static_cast<std::uint32_t>(times.last_ns);
  }
  /// Returns the offset of one point. A negative one is in two's complement, and the caller adds the least, min_ns().
  std::uint32_t operator()(const std::uint8_t* point) {
    if (is_direct_) {
      std::uint32_t value;
      std::memcpy(&value, point + field_.offset, sizeof(value));
      if (value <= last_ns_) return value;
    }
    return is_used_ ? slow(point) : 0;
  }
  std::int64_t min_ns() const { return min_ns_; }
  std::uint64_t num_bad() const { return num_bad_; }

 private:
  std::uint32_t slow(const std::uint8_t* point) {
    const double ns = difference(read_number(point, field_), times_.zero, field_.type) * times_.tick_ns;
    const bool is_of_sweep = ns >= static_cast<double>(times_.first_ns) && ns <= static_cast<double>(times_.last_ns);
    if (!is_of_sweep) {
      ++num_bad_;
      return 0;
    }
    const std::int64_t offset = std::llround(ns);
    min_ns_ = offset < min_ns_ ? offset : min_ns_;
    return static_cast<std::uint32_t>(offset);
  }

  CloudTimes times_;
  FieldAccess field_;
  bool is_used_ = false, is_direct_ = false;
  std::uint32_t last_ns_;
  std::int64_t min_ns_ = 0;
  std::uint64_t num_bad_ = 0;
};

}  // namespace voxnav::cloud
