# SPDX-License-Identifier: Apache-2.0
# cmake -DOUT=<file.cpp> -Dfiles=... -P EmbedFiles.cmake
# Writes the files of the live view's page into a source: what apps/live/server.h declares. Raw strings have a
# largest length, so a text is cut into pieces, which the compiler joins.

cmake_minimum_required(VERSION 3.25)
set(rows "")
foreach(file IN LISTS files)
  get_filename_component(name "${file}" NAME)
  set(path "/${name}")
  set(type "text/plain; charset=utf-8")
  if(name MATCHES "\\.js$")
    set(type "text/javascript; charset=utf-8")
  elseif(name MATCHES "\\.css$")
    set(type "text/css; charset=utf-8")
  elseif(name STREQUAL "page.html")
    set(path "/")
    set(type "text/html; charset=utf-8")
  elseif(name STREQUAL "LICENSE")
    set(path "/uPlot.licence.txt")
  endif()
  file(READ "${file}" content)
  if(content MATCHES "\\)mtfkit_text\"")
    message(FATAL_ERROR "${file}: holds the mark that ends a text here")
  endif()
  set(pieces "")
  string(LENGTH "${content}" length)
  set(at 0)
  while(at LESS length)
    string(SUBSTRING "${content}" ${at} 8000 piece)
    string(APPEND pieces "\n     R\"mtfkit_text(${piece})mtfkit_text\"")
    math(EXPR at "${at} + 8000")
  endwhile()
  string(APPEND rows "    {\"${path}\", \"${type}\",${pieces}},\n")
endforeach()

file(WRITE "${OUT}" "// Generated from apps/live/page.
#include \"apps/live/server.h\"

#include <array>

namespace apps::live {

const PageFile* find_page_file(const std::string& path) {
  static const PageFile files[] = {
${rows}  };
  for (const PageFile& file : files)
    if (file.path == path) return &file;
  return nullptr;
}

}  // namespace apps::live
")
