// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

/// Broken invariants throw in release builds too: a map that is wrong must not be flown.
#define VOXNAV_CHECK(condition, message)                                                                \
  do {                                                                                                  \
    if (!(condition)) throw std::logic_error(std::string(__FILE__) + ": " #condition ": " + (message)); \
  } while (false)
