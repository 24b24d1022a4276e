// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parts of the toolkit in shared libraries of their own, opened when they are needed: those whose libraries take long
// to load and most work does without, and those that a build may leave out. The module `mtfkit_x` is the file
// libmtfkit_x.so; its function `mtfkit_x_table` gives the address of a table of functions, a struct that begins with a
// ModuleBuild. Both sides are built together from the header of the table; a module of another build is refused.

#include <cstddef>
#include <filesystem>
#include <type_traits>

namespace mtf {

/// The build that a module is of: {mtf::version, mtf::git_commit}.
struct ModuleBuild {
  const char *version, *commit;
};

struct Module {
  const char* name;                ///< "mtfkit_x"; the environment variable MTFKIT_X may name the file
  const char* what;                ///< for messages: "the PNG and TIFF codecs"
  bool in_all = false;             ///< whether only `apps/quickstart all` builds it
  const char* package = "mtfkit";  ///< the Debian package that has it
};

/// Whether the module's file is there and complete; loads nothing.
bool has_module(const Module& module);

/// The table of the module. The file is the one that the environment variable names. Else it lies beside the module
/// that this code is in; code in a program or library of users searches the build tree or the installation around it
/// (`lib/mtfkit`), then asks the dynamic loader. Throws RuntimeError for a module that is not there, cannot be opened
/// or is of another build: what it is for, the file, how to get it.
const void* module_table(const Module& module);

template <class Table>
const Table& open_module(const Module& module) {
  static_assert(std::is_standard_layout_v<Table> && offsetof(Table, build) == 0);
  return *static_cast<const Table*>(module_table(module));
}

/// Folder of the shared library or the program that contains `code`: what belongs to the toolkit is found from there,
/// wherever it has been moved to.
std::filesystem::path code_folder(const void* code);

}  // namespace mtf
