# SPDX-License-Identifier: Apache-2.0
# cmake -DLIST=all.h -DROOT=<source> -DOUT=<file.cpp> -P ComponentNotes.cmake
# Writes the comments that open the component headers into a table kind -> text, for `mtf config kinds` and `explain`.
# A header takes part when all.h includes it and it has a `string_view kind = "..."`; all its kinds share the comment.

file(READ "${LIST}" list)
string(REGEX MATCHALL "mtf/components/[a-z0-9_]+\\.h" headers "${list}")
set(rows "")
foreach(header IN LISTS headers)
  file(READ "${ROOT}/${header}" source)
  string(REGEX MATCHALL "string_view kind = \"[a-z0-9_]+\"" kinds "${source}")
  if(NOT kinds)
    continue()
  endif()
  if(NOT source MATCHES "#pragma once\n\n((//[^\n]*\n)+)")
    message(FATAL_ERROR "${header}: has to open with its physics, a comment right after `#pragma once`")
  endif()
  string(REGEX REPLACE "(^|\n)// ?" "\\1" text "${CMAKE_MATCH_1}")
  foreach(kind IN LISTS kinds)
    string(REGEX REPLACE ".*\"([a-z0-9_]+)\"" "\\1" kind "${kind}")
    string(APPEND rows "      {\"${kind}\", R\"notes(${text})notes\"},\n")
  endforeach()
endforeach()

file(WRITE "${OUT}" "// Generated from the comments of mtf/components/*.h.
#include \"mtf/components/component_docs.h\"

namespace mtf {

std::span<const ComponentNotes> all_component_notes() {
  static constexpr ComponentNotes table[] = {
${rows}  };
  return table;
}

}  // namespace mtf
")
