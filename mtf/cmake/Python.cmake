# SPDX-License-Identifier: Apache-2.0
# The Python package, where the system's own Python can have it. The first one on PATH may be an environment without numpy,
# and its module would not load in the other.

if(NOT Python3_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python3_EXECUTABLE /usr/bin/python3)
endif()
find_package(Python3 COMPONENTS Interpreter Development.Module)
if(Python3_Development.Module_FOUND)
  find_package(pybind11 2.10 CONFIG QUIET)
endif()
if(pybind11_FOUND AND TARGET mtfkit_study AND TARGET mtfkit_scene_fly)
  add_subdirectory(apps/python)
else()
  message(STATUS "mtfkit for Python is left out: it needs pybind11 (pybind11-dev), Python's development files, and a build with calib, studies and scenes")
endif()
