// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace voxnav::base {

/// A function of a shared library that lies beside the one of the core. It is loaded with the first call and stays, so
/// that whoever does without it does not carry what it is linked to.
/// @throws std::runtime_error naming the library and why it cannot be loaded
void* plugin_symbol(const char* library, const char* symbol);

template <class Function>
Function* plugin_function(const char* library, const char* symbol) {
  return reinterpret_cast<Function*>(plugin_symbol(library, symbol));
}

}  // namespace voxnav::base
