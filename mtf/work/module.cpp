// SPDX-License-Identifier: Apache-2.0
#include "mtf/work/module.h"

#include <dlfcn.h>
#include <elf.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "mtf/error.h"
#include "mtf/version.h"
#include "mtf/words.h"

namespace mtf {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostWords = 400;

std::string file_name(const Module& module) { return "lib" + std::string(module.name) + ".so"; }

std::string variable(const Module& module) {
  std::string name = module.name;
  for (char& c : name)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return name;
}

/// The file that the user has chosen, or "".
std::string chosen_file(const Module& module) {
  const char* const file = std::getenv(variable(module).c_str());
  return file != nullptr ? file : "";
}

/// The shared library or the program that contains `code`.
fs::path code_file(const void* code) {
  std::error_code error;
  Dl_info where{};
  fs::path file;
  // Of a program dladdr gives argv[0], which need not be a path: a name alone was found on PATH.
  if (::dladdr(code, &where) != 0 && where.dli_fname != nullptr && std::strchr(where.dli_fname, '/') != nullptr)
    file = fs::canonical(where.dli_fname, error);
  if (file.empty() || error) file = fs::canonical("/proc/self/exe", error);
  return file;
}

fs::path this_file() { return code_file(reinterpret_cast<const void*>(&module_table)); }

/// Whether this code is in a module: all modules of an installation lie beside each other, in a folder of their own.
bool is_in_module() {
  const fs::path file = this_file();
  return file.filename().string().rfind("libmtfkit_", 0) == 0 && file.parent_path().filename() == "mtfkit";
}

/// The first place that has the file, or "".
std::string found_file(const Module& module) {
  const auto is_file = [](const fs::path& path) {
    std::error_code error;
    return fs::is_regular_file(path, error);
  };
  if (const std::string chosen = chosen_file(module); !chosen.empty())
    return is_file(chosen) ? fs::absolute(chosen).string() : "";
  fs::path up = this_file().parent_path();
  std::vector<fs::path> places{up};
  if (!is_in_module()) {
    places.insert(places.end(), {up / "mtfkit", up / "lib" / "mtfkit"});
    // Build folder and prefix have the same shape; test programs and Python's modules lie deeper than the command.
    constexpr int depth = 4;
    for (int folder = 0; folder < depth && up != up.root_path(); ++folder) {
      up = up.parent_path();
      for (const char* libraries : {MTFKIT_LIBDIR, "lib"}) places.push_back(up / libraries / "mtfkit");
    }
  }
  const std::string name = file_name(module);
  const auto place = std::find_if(places.begin(), places.end(), [&](const fs::path& p) { return is_file(p / name); });
  return place != places.end() ? (*place / name).string() : "";
}

/// Whether all of a shared library is there: the loader ends the process for one whose end is missing.
bool is_complete(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  Elf64_Ehdr header{};
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  if (error || !in.read(reinterpret_cast<char*>(&header), sizeof header) ||
      std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0 || header.e_phentsize != sizeof(Elf64_Phdr))
    return false;
  in.seekg(static_cast<std::streamoff>(header.e_phoff));
  Elf64_Phdr part{};
  for (int k = 0; k < header.e_phnum; ++k)
    if (!in.read(reinterpret_cast<char*>(&part), sizeof part) || part.p_offset > size ||
        part.p_filesz > size - part.p_offset)
      return false;
  return true;
}

[[noreturn]] void refuse(const Module& module, const std::string& why) {
  const std::string package = module.package;
  throw RuntimeError(std::string(module.what) + ": " + why + "; build it with apps/quickstart" +
                     (module.in_all ? " all" : "") + ", or install the Debian package " + package +
                     (package == "mtfkit" ? ", the tarball or the wheel again" : "") +
                     ", or name the file in the environment variable " + variable(module));
}

}  // namespace

bool has_module(const Module& module) {
  const std::string file = found_file(module);
  return !file.empty() && is_complete(file);
}

const void* module_table(const Module& module) {
  const std::string chosen = chosen_file(module), found = found_file(module);
  if (found.empty() && !chosen.empty()) refuse(module, "there is no file " + printable(chosen, kMostWords));
  if (!found.empty() && !is_complete(found))
    refuse(module, "cannot open the module " + printable(found, kMostWords) + ", which is damaged");
  // A program that links the installed static library lies anywhere: its run path leads to the module.
  const std::string file = found.empty() ? file_name(module) : found;
  void* const handle = found.empty() && is_in_module() ? nullptr : ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr && found.empty())
    refuse(module, "not part of this installation, which has no " +
                       printable((this_file().parent_path() / file).string(), kMostWords));
  if (handle == nullptr) refuse(module, "cannot open the module: " + printable(::dlerror(), kMostWords));
  const std::string function = std::string(module.name) + "_table";
  const auto table_of = reinterpret_cast<const void* (*)()>(::dlsym(handle, function.c_str()));
  const void* const table = table_of != nullptr ? table_of() : nullptr;
  const ModuleBuild* const build = static_cast<const ModuleBuild*>(table);
  if (build == nullptr || std::string_view(build->version) != version || std::string_view(build->commit) != git_commit)
    refuse(module, printable(file, kMostWords) + " is of another build than this program, which is mtfkit " + version +
                       " of commit " + git_commit);
  return table;
}

fs::path code_folder(const void* code) { return code_file(code).parent_path(); }

}  // namespace mtf
