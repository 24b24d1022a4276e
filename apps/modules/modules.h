// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the command keeps in files of their own, beside the library of everything else (libmtfkit_core.so): work whose
// libraries take long to load, and most commands do without, and work that a build may leave out. A module is opened
// when a command asks for its table of functions; help and options of its commands are in the core library, which stays
// as it is when scenes or the live view are added to a build.
//
//   libmtfkit_fits.so     fits and optima: Ceres with SuiteSparse and LAPACK, NLopt
//   libmtfkit_scenes.so   3-D scenes and surface temperatures: Embree, ERFA
//   libmtfkit_live.so     the live view: cpp-httplib with OpenSSL

#include <string>
#include <vector>

#include "apps/options.h"
#include "mtf/work/module.h"
#include "radiometry/atmosphere/atmosphere_settings.h"

namespace apps {

struct RenderCommandOptions;
struct FlyCommandOptions;
struct CharacterizeCommandOptions;

struct FitsModule {
  mtf::ModuleBuild build;
  int (*fit)(const FitOptions&, const Global&);
  int (*optimize)(const OptimizeCommandOptions&, const Global&);
  int (*characterize)(const CharacterizeCommandOptions&, const Global&);
};

/// The air that a scene file describes, for `mtf atmosphere`.
struct SceneAir {
  radiometry::AtmosphereSettings settings;
  double place_m = 0.0;            ///< altitude of the scene's place, where its air begins
  std::vector<std::string> files;  ///< that were read
};

struct ScenesModule {
  mtf::ModuleBuild build;
  int (*scene)(const SceneOptions&, const Global&);
  int (*heat)(const HeatCommandOptions&, const Global&);
  int (*heat_fit)(const HeatCommandOptions&, const Global&);  ///< nullptr in a build without calib
  int (*render)(const RenderCommandOptions&, const Global&);
  int (*fly)(const FlyCommandOptions&, const Global&);
  int (*bench_heat)(const BenchOptions&, const Global&);
  int (*bench_render)(const BenchOptions&, const Global&);
  std::string (*schema)();
  std::string (*starter)();  ///< a scene file to start from
  /// Throws UsageError where the file has no [atmosphere].
  SceneAir (*air)(const std::string& file, const Global&);
  radiometry::atmosphere::Air<double> (*air_above)(const radiometry::AtmosphereSettings&, double altitude_m);
};

struct LiveModule {
  mtf::ModuleBuild build;
  int (*live)(const LiveOptions&, const Global&);
};

/// The table of the module, which is opened where it is not yet. Throw as mtf::open_module does.
const FitsModule& fits_module();
const ScenesModule& scenes_module();
const LiveModule& live_module();

/// Whether the file is there; opens nothing.
bool has_live_module();

/// For `mtf --version`: what is there and what is not, found without opening anything.
std::string modules_text();

}  // namespace apps
