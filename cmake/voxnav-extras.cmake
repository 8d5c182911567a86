# voxnavConfig.cmake of a catkin workspace or installation includes this file, which defines the target voxnav::core.
include(CMakeFindDependencyMacro)
find_dependency(Eigen3)
find_dependency(Threads)
if(NOT TARGET voxnav::core)
  include(${voxnav_DIR}/voxnavTargets.cmake)
endif()
