# This file defines where targets are installed, with catkin and without, and what other packages find.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# The folder of the checkout, which differs from the source folder if its entries are linked into a workspace.
get_filename_component(VOXNAV_CHECKOUT_DIR ${PROJECT_SOURCE_DIR}/CMakeLists.txt REALPATH)
get_filename_component(VOXNAV_CHECKOUT_DIR ${VOXNAV_CHECKOUT_DIR} DIRECTORY)

if(VOXNAV_WITH_ROS)
  set(VOXNAV_INSTALL_LIB ${CATKIN_PACKAGE_LIB_DESTINATION})
  set(VOXNAV_INSTALL_BIN ${CATKIN_PACKAGE_BIN_DESTINATION})
  set(VOXNAV_INSTALL_PYTHON ${CATKIN_PACKAGE_PYTHON_DESTINATION})
  set(VOXNAV_INSTALL_CMAKE ${CATKIN_PACKAGE_SHARE_DESTINATION}/cmake)
else()
  set(VOXNAV_INSTALL_LIB ${CMAKE_INSTALL_LIBDIR})
  set(VOXNAV_INSTALL_BIN ${CMAKE_INSTALL_BINDIR})
  set(VOXNAV_INSTALL_PYTHON lib/python${Python3_VERSION_MAJOR}.${Python3_VERSION_MINOR}/site-packages/voxnav)
  set(VOXNAV_INSTALL_CMAKE ${CMAKE_INSTALL_LIBDIR}/cmake/voxnav)
endif()

# voxnav_install_library(target) installs a library. It finds the libraries beside it without LD_LIBRARY_PATH.
function(voxnav_install_library target)
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN")
  install(TARGETS ${target} ${ARGN} LIBRARY DESTINATION ${VOXNAV_INSTALL_LIB})
endfunction()

# voxnav_install_program(target) installs an executable that finds the libraries of voxnav.
function(voxnav_install_program target)
  voxnav_set_rpath(${target} ${VOXNAV_INSTALL_BIN})
  install(TARGETS ${target} RUNTIME DESTINATION ${VOXNAV_INSTALL_BIN})
endfunction()

# voxnav_install_python_module(target) installs a compiled module inside the Python package.
function(voxnav_install_python_module target)
  voxnav_set_rpath(${target} ${VOXNAV_INSTALL_PYTHON})
  install(TARGETS ${target} LIBRARY DESTINATION ${VOXNAV_INSTALL_PYTHON})
endfunction()

# voxnav_set_rpath(target folder) sets a run path from the folder of the target to the libraries that is relative, so
# that the installation can be moved.
function(voxnav_set_rpath target folder)
  file(RELATIVE_PATH way /prefix/${folder} /prefix/${VOXNAV_INSTALL_LIB})
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "$ORIGIN/${way}")
endfunction()

# Only the headers of the library are installed; those of the nodelets and of the simulator are not for users.
install(DIRECTORY ${VOXNAV_CHECKOUT_DIR}/include/voxnav/ DESTINATION include/voxnav FILES_MATCHING PATTERN "*.hpp")

# voxnav_export_targets() installs what find_package(voxnav) reads, and is called once the targets exist. In a catkin
# workspace catkin writes voxnavConfig.cmake, which includes cmake/voxnav-extras.cmake.
function(voxnav_export_targets)
  install(EXPORT voxnavTargets NAMESPACE voxnav:: DESTINATION ${VOXNAV_INSTALL_CMAKE})
  if(VOXNAV_WITH_ROS)
    export(EXPORT voxnavTargets NAMESPACE voxnav:: FILE ${CATKIN_DEVEL_PREFIX}/share/${PROJECT_NAME}/cmake/voxnavTargets.cmake)
    return()
  endif()
  configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/voxnavConfig.cmake.in ${PROJECT_BINARY_DIR}/voxnavConfig.cmake
    INSTALL_DESTINATION ${VOXNAV_INSTALL_CMAKE})
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/voxnavConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/voxnavConfig.cmake ${PROJECT_BINARY_DIR}/voxnavConfigVersion.cmake
    DESTINATION ${VOXNAV_INSTALL_CMAKE})
endfunction()

if(VOXNAV_WITH_ROS)
  file(GLOB voxnav_scripts CONFIGURE_DEPENDS LIST_DIRECTORIES false ${PROJECT_SOURCE_DIR}/scripts/*)
  catkin_install_python(PROGRAMS ${voxnav_scripts} DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
  foreach(directory launch config rviz tmux worlds)
    # The path is that of the checkout, because CMake would install a link in the workspace instead of its target.
    install(DIRECTORY ${VOXNAV_CHECKOUT_DIR}/${directory}/ DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION}/${directory}
      USE_SOURCE_PERMISSIONS)
  endforeach()
  install(FILES ${VOXNAV_CHECKOUT_DIR}/nodelets.xml ${VOXNAV_CHECKOUT_DIR}/LICENSE DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
endif()
