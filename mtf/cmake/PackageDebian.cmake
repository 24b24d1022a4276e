# SPDX-License-Identifier: Apache-2.0
# Debian packages by CPack: mtfkit (the command), mtfkit-codecs (what needs OpenCV), mtfkit-gdal, mtfkit-libraw, libmtfkit-dev, python3-mtfkit. apps/package
# builds for them below /usr, writes their papers into <build>/papers, and calls CPack.

# Whatever the build has written of these is part of the command.
foreach(pair IN ITEMS man:share/man completion/bash:share/bash-completion/completions
    completion/zsh:share/zsh/vendor-completions completion/fish:share/fish/vendor_completions.d)
  string(REPLACE ":" ";" pair "${pair}")
  list(GET pair 0 from)
  list(GET pair 1 to)
  install(DIRECTORY "${PROJECT_BINARY_DIR}/${from}/" DESTINATION "${to}" COMPONENT command OPTIONAL)
endforeach()
if(NOT CMAKE_INSTALL_PREFIX STREQUAL "/usr" OR NOT PROJECT_IS_TOP_LEVEL)
  return()
endif()

set(this_version "(= ${PROJECT_VERSION})")
set(command_package mtfkit)
set(command_section science)
set(command_words "OTF models of electro-optical and infrared sensors
The command mtf simulates images that a sensor would take, measures the MTF of
edges in images, fits models to it, and rates designs: resolution, noise,
ranges, trade studies, reports.")
set(CPACK_DEBIAN_COMMAND_PACKAGE_RECOMMENDS "mtfkit-codecs, gnuplot-nox")
set(CPACK_DEBIAN_COMMAND_PACKAGE_SUGGESTS "mtfkit-gdal, mtfkit-libraw")
set(opencv_package mtfkit-codecs)
set(opencv_section science)
set(opencv_words "OpenCV for mtfkit
The module with which the command mtf uses OpenCV: mtf bench compares the
speed and the error of its filters with those of OpenCV.")
set(CPACK_DEBIAN_OPENCV_PACKAGE_DEPENDS "mtfkit ${this_version}")
set(gdal_package mtfkit-gdal)
set(gdal_section science)
set(gdal_words "GDAL for mtfkit
The module with which the command mtf reads images of remote sensing: NITF,
HDF5 and JPEG 2000.")
set(CPACK_DEBIAN_GDAL_PACKAGE_DEPENDS "mtfkit ${this_version}")
set(libraw_package mtfkit-libraw)
set(libraw_section science)
set(libraw_words "LibRaw for mtfkit
The module with which the command mtf reads DNG and raw files of cameras.")
set(CPACK_DEBIAN_LIBRAW_PACKAGE_DEPENDS "mtfkit ${this_version}")
set(dev_package libmtfkit-dev)
set(dev_section libdevel)
set(dev_words "OTF models of electro-optical and infrared sensors - development files
Static libraries, headers and the CMake package of mtfkit.")
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "mtfkit ${this_version}, libfftw3-dev, libtbb-dev, libopenexr-dev, libtomlplusplus-dev, pkg-config")
# For some of its libraries only.
set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS "libceres-dev, libnlopt-dev, libnlopt-cxx-dev, liberfa-dev, libembree-dev")
set(python_package python3-mtfkit)
set(python_section python)
set(python_words "OTF models of electro-optical and infrared sensors - Python
The Python package mtfkit: sensors, curves, images, edges, fits and studies
as in the command mtf.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA "${PROJECT_BINARY_DIR}/papers/postinst;${PROJECT_BINARY_DIR}/papers/prerm")
set(components command dev)
foreach(module opencv gdal libraw)
  if(TARGET mtfkit_${module})
    list(APPEND components ${module})
  endif()
endforeach()
if(TARGET mtfkit_python)
  math(EXPR next "${Python3_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "mtfkit ${this_version}, python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${next}), python3-numpy")
  list(APPEND components python)
endif()

set(papers "${PROJECT_BINARY_DIR}/papers")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME mtfkit)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_PACKAGE_VERSION "${PROJECT_VERSION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_DIRECTORY "${PROJECT_BINARY_DIR}/packages")
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${PROJECT_BINARY_DIR}/lib/mtfkit")
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_COMPONENTS_ALL ${components})
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_PRE_BUILD_SCRIPTS "${PROJECT_SOURCE_DIR}/mtf/cmake/PackageTimes.cmake")
foreach(component IN LISTS components)
  string(TOUPPER "${component}" key)
  set(CPACK_DEBIAN_${key}_PACKAGE_NAME "${${component}_package}")
  set(CPACK_DEBIAN_${key}_PACKAGE_SECTION "${${component}_section}")
  set(CPACK_DEBIAN_${key}_DESCRIPTION "${${component}_words}")
  if(NOT component STREQUAL "dev")
    set(CPACK_DEBIAN_${key}_PACKAGE_SHLIBDEPS ON)
  endif()
  install(DIRECTORY "${papers}/${${component}_package}/" DESTINATION share COMPONENT ${component} OPTIONAL)
endforeach()
include(CPack)
