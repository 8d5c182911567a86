// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

#include "base/bytes.hpp"

namespace voxnav::test {

/// Returns bytes with the checksum at their end replaced by a matching one, so that tests of damaged bytes reach the
/// code behind the checksum.
inline std::string resealed(const std::string& bytes) {
  base::ByteWriter out;
  out.put_raw(bytes.data(), bytes.size() - std::min(bytes.size(), sizeof(std::uint32_t)));
  return out.finish();
}

/// Returns bytes of a file or message whose header names another version of the format, with a matching checksum.
inline std::string as_version(std::uint32_t version, const std::string& bytes) {
  std::string out = bytes;
  std::memcpy(out.data() + sizeof(std::uint32_t), &version, sizeof(version));
  return resealed(out);
}

/// Returns the message of the std::invalid_argument that a call throws, or an empty string if it throws none.
template <class Call>
std::string refusal_of(Call&& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

}  // namespace voxnav::test
