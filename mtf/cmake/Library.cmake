# SPDX-License-Identifier: Apache-2.0

# mtfkit_library(name SOURCES files... [PUBLIC libs...] [PRIVATE libs...])
# One library of the toolkit: target mtfkit_<name>, alias and export mtfkit::<name>, installed.
function(mtfkit_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;PUBLIC;PRIVATE")
  set(target mtfkit_${name})
  add_library(${target} ${arg_SOURCES})
  add_library(mtfkit::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} LINKER_LANGUAGE CXX INSTALL_RPATH "\$ORIGIN")
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PUBLIC
    "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>"
    "$<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/generated>"
    "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/mtfkit>")
  target_link_libraries(${target} PUBLIC ${arg_PUBLIC} PRIVATE ${arg_PRIVATE})
  mtfkit_warnings(${target})
  mtfkit_precompile(${target})
  install(TARGETS ${target} EXPORT mtfkitTargets)
endfunction()

# mtfkit_plain_module(target COMPONENT)
# A module (mtf/work/module.h) that is compiled by itself: lib/mtfkit/lib<target>.so, the same place below the build folder
# and below the prefix.
function(mtfkit_plain_module target component)
  target_include_directories(${target} PRIVATE "${PROJECT_SOURCE_DIR}" "${PROJECT_BINARY_DIR}/generated")
  target_compile_features(${target} PRIVATE cxx_std_20)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang" OR NOT CMAKE_CXX_FLAGS MATCHES "-fsanitize")  # what sanitizers need is in the program
    target_link_options(${target} PRIVATE LINKER:--no-undefined)
  endif()
  mtfkit_warnings(${target})
  set_target_properties(${target} PROPERTIES LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/lib/mtfkit")
  install(TARGETS ${target} LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}/mtfkit" COMPONENT ${component})
endfunction()

# mtfkit_precompile(target)
# With MTFKIT_UNITY the standard headers that sources use most are parsed once, with mtfkit_mtf, for all targets. Sources
# name what they use all the same: builds without it see what is missing. GCC compiles with the optimisation of the
# precompiled headers, so sources with options of their own must not have them: SKIP_PRECOMPILE_HEADERS.
function(mtfkit_precompile target)
  if(NOT MTFKIT_UNITY)
    return()
  endif()
  # The same flags for all: some libraries bring -pthread. The warnings are false on precompiled strings in GCC 12.
  target_compile_options(${target} PRIVATE -pthread -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread)
  if(NOT target STREQUAL "mtfkit_mtf")
    target_precompile_headers(${target} REUSE_FROM mtfkit_mtf)
    return()
  endif()
  target_precompile_headers(${target} PRIVATE <algorithm> <array> <charconv> <chrono> <cmath> <complex> <cstdint>
    <fstream> <functional> <limits> <map> <memory> <mutex> <numbers> <numeric> <optional> <set> <span>
    <sstream> <string> <string_view> <tuple> <utility> <variant> <vector>)
endfunction()

# mtfkit_unity(target [ALONE files...] [GROUPED files...])
# With MTFKIT_UNITY the sources of the target (all but ALONE, or only GROUPED) are compiled seven at a time, so that headers
# are read once for each group; a group of GROUPED files is of one folder. For sources without hot loops: groups change
# what is inlined.
function(mtfkit_unity target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "ALONE;GROUPED")
  if(NOT MTFKIT_UNITY)
    return()
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 7)
  set_source_files_properties(${arg_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  if(arg_GROUPED)
    set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
    foreach(file IN LISTS arg_GROUPED)
      cmake_path(GET file PARENT_PATH folder)
      string(MAKE_C_IDENTIFIER "in_${folder}" folder)
      list(APPEND ${folder} "${file}")
      list(LENGTH ${folder} count)
      math(EXPR group "(${count} - 1) / 7")
      set_source_files_properties(${file} PROPERTIES UNITY_GROUP "${folder}_${group}")
    endforeach()
  endif()
endfunction()

# mtfkit_embed(files...): texts that stand in the program, FOLDER/NAME.toml as mtf::embedded::NAME_toml of FOLDER/NAME.toml.h.
function(mtfkit_embed)
  foreach(file IN LISTS ARGN)
    cmake_path(ABSOLUTE_PATH file BASE_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}")
    cmake_path(RELATIVE_PATH file BASE_DIRECTORY "${PROJECT_SOURCE_DIR}" OUTPUT_VARIABLE from)
    cmake_path(GET file FILENAME name)
    string(MAKE_C_IDENTIFIER "${name}" name)
    file(READ "${file}" text)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${file}")
    file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/generated/${from}.h" @ONLY CONTENT [[// Generated from @from@.
#pragma once

#include <string_view>

namespace mtf::embedded {
inline constexpr std::string_view @name@ = R"mtfkit_text(@text@)mtfkit_text";
}
]])
  endforeach()
endfunction()

# mtfkit_install_headers(umbrella): the public headers, which are those that the umbrella header names, and what they include
# of any library, under include/mtfkit.
function(mtfkit_install_headers umbrella)
  set(queue "${umbrella}")
  set(seen "")
  while(queue)
    list(POP_FRONT queue header)
    if(NOT header IN_LIST seen AND EXISTS "${PROJECT_SOURCE_DIR}/${header}")
      list(APPEND seen "${header}")
      cmake_path(GET header PARENT_PATH place)
      install(FILES "${PROJECT_SOURCE_DIR}/${header}" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/mtfkit/${place}")
      set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/${header}")
      file(STRINGS "${PROJECT_SOURCE_DIR}/${header}" includes REGEX "^#include \"[a-z]+/")
      list(TRANSFORM includes REPLACE "^#include \"([^\"]+)\".*" "\\1")
      list(APPEND queue ${includes})
    endif()
  endwhile()
endfunction()
