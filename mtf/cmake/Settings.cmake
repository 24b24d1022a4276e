# SPDX-License-Identifier: Apache-2.0
# Build settings of the whole tree. Optimisation comes from the build type alone: one binary has to run on any x86-64,
# and strict floating point is part of the accuracy promise, so neither -march=native nor -ffast-math belongs here.

get_property(multi_config GLOBAL PROPERTY GENERATOR_IS_MULTI_CONFIG)
if(NOT CMAKE_BUILD_TYPE AND NOT multi_config)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

# Allows sqrt and selections in vector loops; errno and trap handlers are not used, values stay IEEE.
add_compile_options(-fno-math-errno -fno-trapping-math)

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)

# Files of the build tree look for modules below lib/mtfkit, as in an installation; installed ones get run paths of their
# own (apps/CMakeLists.txt, mtf/io/CMakeLists.txt). No folder of this machine is in them, so that the same files come out
# wherever they are built.
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/lib")
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/lib")
set(CMAKE_BUILD_RPATH "\$ORIGIN;\$ORIGIN/../lib/mtfkit;\$ORIGIN/../../lib/mtfkit")
set(CMAKE_BUILD_RPATH_USE_ORIGIN ON)

find_program(MTFKIT_CCACHE ccache DOC "Compiler cache, used when found")
if(MTFKIT_CCACHE AND NOT DEFINED CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER "${MTFKIT_CCACHE}")
endif()
