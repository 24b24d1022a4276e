// SPDX-License-Identifier: Apache-2.0
#include "apps/modules/modules.h"

#include "mtf/io/codecs/codecs.h"
#include "mtf/io/codecs/opencv_filters.h"

namespace apps {
namespace {

using mtf::has_module, mtf::open_module;

constexpr mtf::Module kFits{"mtfkit_fits", "fits and optima (mtf fit, mtf optimize)"};
constexpr mtf::Module kScenes{
    .name = "mtfkit_scenes", .what = "3-D scenes (mtf scene, heat, render, fly)", .in_all = true};
constexpr mtf::Module kLive{.name = "mtfkit_live", .what = "the live view (mtf live)", .in_all = true};

}  // namespace

const FitsModule& fits_module() {
  static const FitsModule& table = open_module<FitsModule>(kFits);
  return table;
}

const ScenesModule& scenes_module() {
  static const ScenesModule& table = open_module<ScenesModule>(kScenes);
  return table;
}

const LiveModule& live_module() {
  static const LiveModule& table = open_module<LiveModule>(kLive);
  return table;
}

bool has_live_module() { return has_module(kLive); }

std::string modules_text() {
  std::string here, missing;
  const auto tell = [&](bool there, const std::string& what) {
    std::string& list = there ? here : missing;
    list += (list.empty() ? "" : "; ") + what;
  };
  tell(mtf::io::has_codecs(), "PNG, TIFF and JPEG");
  tell(mtf::io::has_opencv(), "OpenCV as the rival of mtf bench");
  for (const mtf::Module& module : {kFits, kScenes, kLive}) tell(has_module(module), module.what);
  return "present: " + (here.empty() ? "the core only" : here) +
         "\nmissing: " + (missing.empty() ? "nothing" : missing);
}

}  // namespace apps
