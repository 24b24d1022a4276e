# SPDX-License-Identifier: Apache-2.0

# mtfkit_warnings(target): the warnings of our own sources; headers of dependencies are SYSTEM and stay silent.
# MTFKIT_WERROR makes them errors, except those that GCC derives from its optimiser: they come and go with inlining.
function(mtfkit_warnings target)
  set(warnings -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wold-style-cast -Wcast-align
    -Wnon-virtual-dtor -Woverloaded-virtual -Wundef)
  if(MTFKIT_WERROR)
    list(APPEND warnings -Werror)
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # -Wrestrict: false on string concatenation in GCC 12 (GCC bug 105651).
    list(APPEND warnings -Wno-restrict -Wno-error=array-bounds -Wno-error=maybe-uninitialized
      -Wno-error=stringop-overflow -Wno-error=stringop-overread)
  endif()
  target_compile_options(${target} PRIVATE ${warnings})
endfunction()
