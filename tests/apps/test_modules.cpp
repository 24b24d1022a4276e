// SPDX-License-Identifier: Apache-2.0

// The command and its modules: what a start loads, and a module that is missing, damaged or another one.

#include <gtest/gtest.h>

#include <string>

#include "tests/apps/command.h"

namespace apps_test {
namespace {

const fs::path kModules = fs::path(MTFKIT_COMMAND).parent_path().parent_path() / "lib" / "mtfkit";

// A start is to load what most commands need and no more: these came with fits, scenes and the live view.
TEST(Modules, AStartLoadsNoLibraryOfFewCommands) {
  const Scratch scratch;
  const Result loaded = scratch.run("LD_TRACE_LOADED_OBJECTS=1 '" MTFKIT_COMMAND "'");
  ASSERT_EQ(loaded.status, 0) << loaded.err;
  ASSERT_NE(loaded.out.find("libmtfkit_core.so"), std::string::npos) << loaded.out;
  for (const char* library : {"ceres", "glog", "cholmod", "lapack", "blas", "nlopt", "embree", "erfa", "httplib",
                              "libssl", "libcrypto", "opencv", "libpng", "libtiff"})
    EXPECT_FALSE(says(loaded.out, library)) << library << "\n" << loaded.out;
}

// Two copies of a function with state (files to remove on a signal, planners) would not know of one another.
TEST(Modules, NoFunctionOrVariableIsInTwoOfThem) {
  const Scratch scratch;
  std::string files;
  for (const char* name : {"core", "fits", "scenes", "live"}) {
    const fs::path file = kModules / ("libmtfkit_" + std::string(name) + ".so");
    if (fs::exists(file)) files += " '" + file.string() + "'";
  }
  const Result names = scratch.run("nm -D --defined-only" + files +
                                   " | awk '$2 ~ /^[TDBR]$/ && $3 ~ /mtf|apps|radiometry|calib/ {print $3}' > names;"
                                   " wc -l < names; sort names | uniq -d");
  ASSERT_EQ(names.status, 0) << names.err;
  EXPECT_GT(std::stoi(names.out), 100);
  EXPECT_EQ(names.out.substr(names.out.find('\n') + 1), "");
}

// Beside the core library, and in one place only.
TEST(Modules, OneThatIsMissingDamagedOrAnotherIsNamedWithTheRemedy) {
  const Scratch scratch;
  const fs::path here = fs::canonical(scratch / ".");
  fs::copy_file(kModules / "libmtfkit_core.so", here / "libmtfkit_core.so");
  write_file(here / "scene.toml", "schema = 1\n");
  const std::string mtf = "LD_LIBRARY_PATH='" + here.string() + "' mtf ";
  const std::string module = (here / "libmtfkit_scenes.so").string();
  const auto refused = [&](const std::string& command, const std::string& why) {
    const Result result = scratch.run(mtf + command);
    EXPECT_EQ(result.status, 1) << command << "\n" << result.out;
    EXPECT_EQ(result.out, "");
    expect_says(result.err, {why, module, "apps/quickstart all", "Debian package mtfkit"});
  };
  for (const char* command :
       {"heat scene.toml -o t", "render scene.toml s.toml -o p.exr", "config schema scene", "bench scene.toml -o b"})
    refused(command, "has no " + module);
  EXPECT_EQ(scratch.run(mtf + "heat --help").out, scratch.run("mtf heat --help").out);
  const std::string version = scratch.run(mtf + "--version").out;
  EXPECT_LT(version.find("\nmissing: "), version.find("3-D scenes")) << version;

  write_file(module, "no library");
  refused("heat scene.toml -o t", "cannot open");
  for (const std::uintmax_t size : {std::uintmax_t{20000}, fs::file_size(kModules / "libmtfkit_scenes.so") / 2}) {
    fs::copy_file(kModules / "libmtfkit_scenes.so", module, fs::copy_options::overwrite_existing);
    fs::resize_file(module, size);
    refused("heat scene.toml -o t", "damaged");
    const std::string told = scratch.run(mtf + "--version").out;
    EXPECT_LT(told.find("\nmissing: "), told.find("3-D scenes")) << told;
  }
  fs::remove(module);
  fs::copy_file(kModules / "libmtfkit_core.so", module);  // opens, and has no table of scenes
  refused("heat scene.toml -o t", "another build");
}

}  // namespace
}  // namespace apps_test
