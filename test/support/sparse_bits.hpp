// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace voxnav::test {

/// Returns a random number in which each bit is set with the probability 2^-num_draws.
template <class Random>
typename Random::result_type sparse_bits(Random* random, int num_draws) {
  typename Random::result_type out = (*random)();
  for (int draw = 1; draw < num_draws; ++draw) out &= (*random)();
  return out;
}

}  // namespace voxnav::test
