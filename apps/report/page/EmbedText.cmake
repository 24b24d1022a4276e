# SPDX-License-Identifier: Apache-2.0
# cmake -DOUT=<file.cpp> -Dpage=... -Dstyle=... -Dscript=... -Dlibrary=... -Dnotices=... -P EmbedText.cmake
# Writes text files into a source: what apps/page/html.h declares. Each variable is a list of files, maybe empty,
# whose texts are put one after the other.

cmake_minimum_required(VERSION 3.25)
set(members "")
foreach(member page style script library notices)
  set(text "")
  foreach(file IN LISTS ${member})
    file(READ "${file}" content)
    if(content MATCHES "\\)mtfkit_text\"")
      message(FATAL_ERROR "${file}: holds the mark that ends a text here")
    endif()
    if(NOT member STREQUAL "page" AND content MATCHES "</script|<!--")
      message(FATAL_ERROR "${file}: holds what ends or changes a script element")
    endif()
    # Maps are not shipped; a browser's tools would ask for them.
    string(REGEX REPLACE "\n//# sourceMappingURL=[^\n]*" "" content "${content}")
    string(APPEND text "${content}\n")
  endforeach()
  string(APPEND members "      .${member} = R\"mtfkit_text(${text})mtfkit_text\",\n")
endforeach()

file(WRITE "${OUT}" "// Generated from apps/report.
#include \"apps/page/html.h\"

namespace apps {

const ReportFiles& report_files() {
  static const ReportFiles files{
${members}  };
  return files;
}

}  // namespace apps
")
