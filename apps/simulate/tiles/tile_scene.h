// SPDX-License-Identifier: Apache-2.0
#pragma once

// The scene of a run in tiles: in memory or, where memory is limited, as windows of its file.

#include <optional>
#include <string>
#include <vector>

#include "apps/simulate/scene_source.h"
#include "apps/simulate/simulate_parts.h"
#include "mtf/io/exr/exr_windows.h"
#include "mtf/tiles/tiles.h"

namespace apps {

struct TileScene {
  mtf::io::Scene scene;
  std::optional<mtf::io::ExrWindows> file;
  std::vector<mtf::ImageView<const float>> planes;
  mtf::ReadWindow read;
};

/// Why a scene, an output or a treatment of bad pixels needs the whole image, as the message of an error; "" where the
/// scene can be read and the image be written in pieces.
std::string refusal_of_windows(const SimulateOptions& options, const SceneSource& file);

/// Opens the file of a scene that is read in windows; `scene` stays where it is. Throws UsageError with
/// refusal_of_windows().
void open_windows(const SimulateOptions& options, const mtf::io::SensorConfig& config, const SceneSource& file,
                  TileScene& source);

struct SceneSurvey {
  mtf::Border border = mtf::Border::reflect;
  double border_value = 0.0;
  std::int64_t every = 0;   ///< scene samples for one of the coarse image, 0 = none
  std::int64_t memory = 0;  ///< an eighth of it is for rows; 0 = as many as are read together
  int threads = 0;
  std::string_view step = "survey";  ///< its name in progress
  bool computed = false;             ///< the samples are made of finite ones: those that are not finite exceed float32
};

/// Every channel surveyed, within the memory that rows may take. Throws RuntimeError for samples that are not finite.
std::vector<mtf::Survey> survey_all(TileScene& source, const SceneSurvey& asked, RunWatch& watch);

/// All that the pixels of a run in tiles depend on; `stage` is that of a chain whose output they are, "" without one.
std::string key_of(const SimulateOptions& options, const mtf::io::SensorConfig& config, const std::string& file,
                   const TileScene& source, const std::vector<mtf::Survey>& surveys, const mtf::TiledSensorPlan& plan,
                   const std::string& stage);

}  // namespace apps
