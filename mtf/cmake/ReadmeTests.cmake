# SPDX-License-Identifier: Apache-2.0
# Every README is run block by block, in order, in one scratch folder (tests/readme_blocks.py). Its C++ blocks become
# executables here, so that a snippet that no longer compiles breaks the build.

if(NOT TARGET mtfkit_cli)
  return()
endif()

set(blocks_script "${PROJECT_SOURCE_DIR}/tests/readme_blocks.py")
set(snippets_dir "${CMAKE_CURRENT_BINARY_DIR}/readme")
execute_process(
  COMMAND "${Python3_EXECUTABLE}" "${blocks_script}" --extract-cpp "${snippets_dir}"
  OUTPUT_VARIABLE readmes COMMAND_ERROR_IS_FATAL ANY OUTPUT_STRIP_TRAILING_WHITESPACE)
string(REPLACE "\n" ";" readmes "${readmes}")

foreach(line IN LISTS readmes)
  # README path | yes when it has long blocks | its snippets
  string(REPLACE "|" ";" fields "${line}")
  list(POP_FRONT fields readme has_long)
  if(readme MATCHES "^(apps/scene|radiometry/heat|radiometry/render|radiometry/scene|radiometry/thermal)/" AND NOT TARGET mtfkit_scene_fly)
    continue()
  endif()
  if(readme STREQUAL "apps/python/README.md" AND NOT TARGET mtfkit_python)
    continue()
  endif()
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/${readme}" "${blocks_script}")
  foreach(snippet IN LISTS fields)
    add_executable(${snippet} "${snippets_dir}/${snippet}.cpp")
    set_target_properties(${snippet} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${snippets_dir}")
    target_link_libraries(${snippet} PRIVATE mtfkit::simulate $<TARGET_NAME_IF_EXISTS:mtfkit::calib>
      $<TARGET_NAME_IF_EXISTS:mtfkit::weather> $<TARGET_NAME_IF_EXISTS:mtfkit::heat> $<TARGET_NAME_IF_EXISTS:mtfkit::render>
      $<TARGET_NAME_IF_EXISTS:mtfkit::scene_fly>       mtfkit::atmosphere)
  endforeach()

  set(run "${blocks_script}" --run "${readme}" --mtf "$<TARGET_FILE:mtfkit_cli>" --snippets "${snippets_dir}")
  add_test(NAME "readme/${readme}" COMMAND Python3::Interpreter ${run})
  set_tests_properties("readme/${readme}" PROPERTIES TIMEOUT 300)
  if(has_long STREQUAL "yes")
    add_test(NAME "readme-long/${readme}" COMMAND Python3::Interpreter ${run} --long)
    set_tests_properties("readme-long/${readme}" PROPERTIES TIMEOUT 3000 LABELS long)
  endif()
endforeach()
