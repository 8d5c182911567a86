// SPDX-License-Identifier: BSD-3-Clause
#include "base/plugin.hpp"

#include <dlfcn.h>

#include <stdexcept>
#include <string>

namespace voxnav::base {
namespace {

/// The folder of the core's own library, with a slash at its end.
std::string own_folder() {
  Dl_info info;
  if (dladdr(reinterpret_cast<const void*>(&plugin_symbol), &info) == 0 || info.dli_fname == nullptr) return "";
  const std::string path = info.dli_fname;
  return path.substr(0, path.find_last_of('/') + 1);
}

[[noreturn]] void fail(const char* library) {
  const char* why = dlerror();
  throw std::runtime_error(std::string("voxnav was built without ") + library +
                           ", or it cannot be loaded: " + (why != nullptr ? why : "unknown"));
}

}  // namespace

void* plugin_symbol(const char* library, const char* symbol) {
  void* handle = dlopen((own_folder() + library).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) fail(library);
  void* found = dlsym(handle, symbol);
  if (found == nullptr) fail(library);
  return found;
}

}  // namespace voxnav::base
