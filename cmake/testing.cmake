# Tests of the core are gtest executables, those in Python are run by pytest, and those of the nodes by rostest.
# In a catkin workspace CATKIN_ENABLE_TESTING enables them, the target `tests` builds them and `run_tests` runs them
# (catkin_make run_tests, catkin test voxnav), and their JUnit results are where catkin_test_results looks. Elsewhere
# VOXNAV_BUILD_TESTS enables them and ctest runs them. In ctest they have the labels cpp, python and ros.
if(VOXNAV_WITH_ROS)
  set(VOXNAV_TESTING ${CATKIN_ENABLE_TESTING})
else()
  option(VOXNAV_BUILD_TESTS "Build the C++ tests" ON)
  set(VOXNAV_TESTING ${VOXNAV_BUILD_TESTS})
endif()

# A test that hangs is stopped after this time. All Python tests are one of them, and may run on a loaded machine.
set(VOXNAV_TEST_TIMEOUT_S 3600)

# voxnav_register_test(kind name label command target...) registers a test, whose command writes its JUnit results to
# ${CATKIN_TEST_RESULTS_DIR}/voxnav/<kind>-<name>.xml and needs the targets.
function(voxnav_register_test kind name label command)
  catkin_run_tests_target(${kind} ${name} ${kind}-${name}.xml COMMAND "${command}" DEPENDENCIES ${ARGN}
    WORKING_DIRECTORY ${VOXNAV_CHECKOUT_DIR})
  set_tests_properties(_ctest_${PROJECT_NAME}_${kind}_${name} PROPERTIES LABELS ${label} TIMEOUT ${VOXNAV_TEST_TIMEOUT_S})
endfunction()

# voxnav_unit_test(name source...) adds a gtest executable, whose sources may include what is in test/support.
function(voxnav_unit_test name)
  add_executable(${name} ${ARGN})
  target_link_libraries(${name} PRIVATE voxnav_core_internals GTest::GTest GTest::Main)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/test/support)
  voxnav_target_options(${name})
  voxnav_share_precompiled(${name} voxnav_test_headers)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  if(VOXNAV_WITH_ROS)
    # This does what catkin_add_gtest does, which cannot be used because it knows nothing of shared precompiled headers.
    set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL ON)
    add_dependencies(tests ${name})
    voxnav_register_test(gtest ${name} cpp
      "$<TARGET_FILE:${name}> --gtest_output=xml:${CATKIN_TEST_RESULTS_DIR}/${PROJECT_NAME}/gtest-${name}.xml" ${name})
  else()
    add_test(NAME ${name} COMMAND ${name})
    set_tests_properties(${name} PROPERTIES LABELS cpp TIMEOUT ${VOXNAV_TEST_TIMEOUT_S})
  endif()
endfunction()

# voxnav_pytest(name folder) registers all tests below the folder as one run of pytest.
function(voxnav_pytest name folder)
  set(results ${CATKIN_TEST_RESULTS_DIR}/${PROJECT_NAME}/pytest-${name}.xml)
  voxnav_register_test(pytest ${name} python
    "nice -n 5 ${PYTHON_EXECUTABLE} -m pytest -q -p no:cacheprovider --junitxml=${results} ${folder}" ${VOXNAV_RUNTIME_TARGETS})
endfunction()

# voxnav_rostest(file) registers a .test file of rostest.
function(voxnav_rostest file)
  add_rostest(${file} DEPENDENCIES ${VOXNAV_RUNTIME_TARGETS} WORKING_DIRECTORY ${VOXNAV_CHECKOUT_DIR})
  get_filename_component(name ${file} NAME)
  # Two flights at the same time would make each other late, so the lock lets only one of these tests run at a time.
  set_tests_properties(_ctest_${PROJECT_NAME}_rostest_test_rostest_${name} PROPERTIES
    LABELS ros TIMEOUT ${VOXNAV_TEST_TIMEOUT_S} RESOURCE_LOCK flight
    ENVIRONMENT "ROS_HOME=${CATKIN_TEST_RESULTS_DIR}/ros_home;ROS_IP=127.0.0.1")
endfunction()
