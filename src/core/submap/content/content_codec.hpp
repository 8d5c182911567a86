// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/bytes.hpp"
#include "submap/content/submap_content.hpp"

/// The content of a submap as bytes, as docs/map_format.md lists them.
namespace voxnav::submap {

void write_content(const SubmapContent& content, base::ByteWriter* out);
/// @throws std::invalid_argument naming which parts do not fit each other
SubmapContent read_content(base::ByteReader* in);

}  // namespace voxnav::submap
