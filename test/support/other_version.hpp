// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "base/bytes.hpp"

namespace voxnav::test {

/// The same file or message as another version of its format would begin, with a checksum that fits.
inline std::string as_version(std::uint32_t version, const std::string& bytes) {
  constexpr std::size_t kMagic = sizeof(std::uint32_t), kHeader = 2 * kMagic, kSum = sizeof(std::uint32_t);
  base::ByteWriter out;
  out.put_raw(bytes.data(), kMagic);
  out.put(version);
  out.put_raw(bytes.data() + kHeader, bytes.size() - kHeader - kSum);
  return out.finish();
}

/// What a call says when it throws std::invalid_argument; empty when it does not.
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
