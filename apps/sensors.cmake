# SPDX-License-Identifier: Apache-2.0
# mtfkit_sensors: from a sensor file to the chain of radiometry, for the command and for studies.

add_library(mtfkit_sensors STATIC
  "${PROJECT_SOURCE_DIR}/apps/sensor_chain.cpp"
  "${PROJECT_SOURCE_DIR}/apps/sensor_place.cpp")
target_link_libraries(mtfkit_sensors PUBLIC mtfkit_mtf mtfkit_io mtfkit_radiometry)
mtfkit_warnings(mtfkit_sensors)
