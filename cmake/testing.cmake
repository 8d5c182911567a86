# Tests: gtest executables for the core, pytest for everything in Python, rostest for the nodes.
# In a catkin workspace CATKIN_ENABLE_TESTING decides, the tests are built by the target `tests` and run by `run_tests`
# (catkin_make run_tests, catkin test voxnav), and their JUnit results lie where catkin_test_results looks. Elsewhere
# VOXNAV_BUILD_TESTS decides and ctest runs them. ctest knows all of them by the labels cpp, python and ros.
if(VOXNAV_WITH_ROS)
  set(VOXNAV_TESTING ${CATKIN_ENABLE_TESTING})
else()
  option(VOXNAV_BUILD_TESTS "Build the C++ tests" ON)
  set(VOXNAV_TESTING ${VOXNAV_BUILD_TESTS})
endif()

# A test that hangs is stopped after this time.
set(VOXNAV_TEST_TIMEOUT_S 600)

# voxnav_register_test(kind name label command): the command writes its JUnit results to
# ${CATKIN_TEST_RESULTS_DIR}/voxnav/<kind>-<name>.xml. Further arguments are targets that it needs.
function(voxnav_register_test kind name label command)
  catkin_run_tests_target(${kind} ${name} ${kind}-${name}.xml COMMAND "${command}" DEPENDENCIES ${ARGN}
    WORKING_DIRECTORY ${VOXNAV_CHECKOUT_DIR})
  set_tests_properties(_ctest_${PROJECT_NAME}_${kind}_${name} PROPERTIES LABELS ${label} TIMEOUT ${VOXNAV_TEST_TIMEOUT_S})
endfunction()

# voxnav_unit_test(name source...): one gtest executable. Seeds are fixed; sources share test/support.
function(voxnav_unit_test name)
  add_executable(${name} ${ARGN})
  target_link_libraries(${name} PRIVATE voxnav_core_internals GTest::GTest GTest::Main)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/test/support)
  voxnav_target_options(${name})
  voxnav_share_precompiled(${name} voxnav_test_headers)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  if(VOXNAV_WITH_ROS)
    # As catkin_add_gtest does, which would compile every source without the shared precompiled headers.
    set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL ON)
    add_dependencies(tests ${name})
    voxnav_register_test(gtest ${name} cpp
      "$<TARGET_FILE:${name}> --gtest_output=xml:${CATKIN_TEST_RESULTS_DIR}/${PROJECT_NAME}/gtest-${name}.xml" ${name})
  else()
    add_test(NAME ${name} COMMAND ${name})
    set_tests_properties(${name} PROPERTIES LABELS cpp TIMEOUT ${VOXNAV_TEST_TIMEOUT_S})
  endif()
endfunction()

# voxnav_pytest(name folder): all tests below the folder, by pytest.
function(voxnav_pytest name folder)
  set(results ${CATKIN_TEST_RESULTS_DIR}/${PROJECT_NAME}/pytest-${name}.xml)
  voxnav_register_test(pytest ${name} python
    "nice -n 5 ${PYTHON_EXECUTABLE} -m pytest -q -p no:cacheprovider --junitxml=${results} ${folder}" ${VOXNAV_RUNTIME_TARGETS})
endfunction()

# voxnav_rostest(file): one .test file of rostest.
function(voxnav_rostest file)
  add_rostest(${file} DEPENDENCIES ${VOXNAV_RUNTIME_TARGETS} WORKING_DIRECTORY ${VOXNAV_CHECKOUT_DIR})
  get_filename_component(name ${file} NAME)
  # Flights share the processor with nothing but the Python tests: one at a time.
  set_tests_properties(_ctest_${PROJECT_NAME}_rostest_test_rostest_${name} PROPERTIES
    LABELS ros TIMEOUT ${VOXNAV_TEST_TIMEOUT_S} RESOURCE_LOCK flight
    ENVIRONMENT "ROS_HOME=${CATKIN_TEST_RESULTS_DIR}/ros_home;ROS_IP=127.0.0.1")
endfunction()
