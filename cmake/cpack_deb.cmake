# This is CPack's configuration of the Debian package. scripts/dev/build_deb adds the folder of the build, and the
# dependencies besides the libraries that the binaries are linked to.
file(READ ${CMAKE_CURRENT_LIST_DIR}/../package.xml manifest)
string(REGEX MATCH "<version>([^<]*)</version>" _ "${manifest}")
set(CPACK_PACKAGE_VERSION ${CMAKE_MATCH_1})
string(REGEX MATCH "<maintainer email=\"([^\"]*)\">([^<]*)</maintainer>" _ "${manifest}")
set(CPACK_PACKAGE_CONTACT "${CMAKE_MATCH_2} <${CMAKE_MATCH_1}>")
string(REGEX MATCH "<description>([^<]*)</description>" _ "${manifest}")
string(REGEX REPLACE "[ \n]+" " " description "${CMAKE_MATCH_1}")

set(CPACK_GENERATOR DEB)
set(CPACK_CMAKE_GENERATOR "Unix Makefiles")
set(CPACK_PACKAGE_NAME voxnav)
set(CPACK_PACKAGE_VENDOR voxnav)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "LiDAR mapping and safe planning for UAVs")
set(CPACK_PACKAGE_DESCRIPTION "LiDAR mapping and safe planning for UAVs\n ${description}")
set(CPACK_INSTALL_PREFIX /opt/voxnav)
set(CPACK_SET_DESTDIR ON)
set(CPACK_STRIP_FILES ON)
# CPack requires the first name, but the package gets the second.
set(CPACK_PACKAGE_FILE_NAME voxnav)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
