# Part of voxnavConfig.cmake in a catkin workspace or installation: target voxnav::core, as without ROS.
include(CMakeFindDependencyMacro)
find_dependency(Eigen3)
find_dependency(Threads)
if(NOT TARGET voxnav::core)
  include(${voxnav_DIR}/voxnavTargets.cmake)
endif()
