// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "kernels/processor.hpp"

namespace voxnav::test {

/// Runs a test once with the instructions that every processor of this architecture has, and if this processor has
/// more, once with all of its own. Afterwards kernels may use all of them again.
template <class Test>
void with_every_instruction_set(Test&& test) {
  kernels::use_wide(false);
  test();
  kernels::use_wide(true);
  if (kernels::is_wide()) test();
}

}  // namespace voxnav::test
