# SPDX-License-Identifier: Apache-2.0
# find_package(mtfkit COMPONENTS mtf io radiometry atmosphere weather heat scene thermal render calib sensors simulate study mesh_import scene_outputs vehicle
#   weather_files scene_file scene_heat scene_render scene_fly)

include(CMakePackageConfigHelpers)
set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/mtfkit")
configure_package_config_file("${PROJECT_SOURCE_DIR}/mtf/cmake/mtfkitConfig.cmake.in"
  "${PROJECT_BINARY_DIR}/mtfkitConfig.cmake" INSTALL_DESTINATION "${package_dir}")
write_basic_package_version_file("${PROJECT_BINARY_DIR}/mtfkitConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/mtfkitConfig.cmake" "${PROJECT_BINARY_DIR}/mtfkitConfigVersion.cmake"
  DESTINATION "${package_dir}")
install(EXPORT mtfkitTargets NAMESPACE mtfkit:: DESTINATION "${package_dir}")
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT license)
include(PackageDebian)
