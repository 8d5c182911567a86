// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

/// Invariants are checked in release builds, too, and a broken one throws: nobody may fly by a map that is wrong.
#define VOXNAV_CHECK(condition, message)                                                                \
  do {                                                                                                  \
    if (!(condition)) throw std::logic_error(std::string(__FILE__) + ": " #condition ": " + (message)); \
  } while (false)
