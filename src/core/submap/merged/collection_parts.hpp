// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "submap/merged/submap_merge.hpp"
#include "submap/merged/submap_store.hpp"
#include "voxnav/submap/submap_collection.hpp"

namespace voxnav::submap {

struct SubmapCollection::Parts {
  explicit Parts(const SubmapCollectionConfig& c) : config(base::checked(c)), store(config), merge(config) {}

  SubmapCollectionConfig config;
  SubmapStore store;
  SubmapMerge merge;
  std::uint64_t num_dropped = 0;
};

}  // namespace voxnav::submap
