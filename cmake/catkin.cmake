# This file generates messages and services and exports the package to catkin.
find_package(catkin REQUIRED COMPONENTS
  roscpp rospy nodelet pluginlib tf2 tf2_msgs tf2_ros std_msgs std_srvs geometry_msgs sensor_msgs nav_msgs
  visualization_msgs rosgraph_msgs mrs_msgs octomap_msgs message_generation)

catkin_python_setup()  # must come before generate_messages()

file(STRINGS msg/files.txt voxnav_messages REGEX "^[^#]")
file(STRINGS srv/files.txt voxnav_services REGEX "^[^#]")
add_message_files(DIRECTORY msg FILES ${voxnav_messages})
add_service_files(DIRECTORY srv FILES ${voxnav_services})
generate_messages(DEPENDENCIES std_msgs geometry_msgs sensor_msgs nav_msgs visualization_msgs mrs_msgs octomap_msgs)

catkin_package(
  INCLUDE_DIRS include
  LIBRARIES voxnav_core
  CATKIN_DEPENDS roscpp rospy nodelet tf2 tf2_msgs tf2_ros std_msgs std_srvs geometry_msgs sensor_msgs nav_msgs
    visualization_msgs mrs_msgs octomap_msgs message_runtime
  DEPENDS EIGEN3
  CFG_EXTRAS voxnav-extras.cmake)

set(VOXNAV_PYTHON_DIR ${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_PYTHON_DESTINATION})

# Catkin runs tests in a copy of the environment that it took when the workspace was configured. In a workspace that was
# never configured before, that copy lacks the folders that did not exist at that moment, and no test would find voxnav.
# So the folders are made, and the copy is taken again.
set(voxnav_environment_script ${CMAKE_BINARY_DIR}/catkin_generated/generate_cached_setup.py)
if(EXISTS ${voxnav_environment_script})
  file(MAKE_DIRECTORY ${VOXNAV_PYTHON_DIR} ${CATKIN_DEVEL_PREFIX}/${CATKIN_GLOBAL_LIB_DESTINATION})
  execute_process(COMMAND ${PYTHON_EXECUTABLE} ${voxnav_environment_script} RESULT_VARIABLE voxnav_environment_failed)
  if(voxnav_environment_failed)
    message(FATAL_ERROR "Catkin's environment for tests could not be written by ${voxnav_environment_script}")
  endif()
endif()
