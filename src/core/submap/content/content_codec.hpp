// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/bytes.hpp"
#include "submap/content/submap_content.hpp"

/// Serialises the content of a submap in the format of docs/map_format.md.
namespace voxnav::submap {

void write_content(const SubmapContent& content, base::ByteWriter* out);
/// @throws std::invalid_argument naming the parts that do not fit each other
SubmapContent read_content(base::ByteReader* in);

}  // namespace voxnav::submap
