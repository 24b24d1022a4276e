// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the commands of scenes read: a scene file, and instants of options.

#include <optional>
#include <string>

#include "apps/options.h"
#include "apps/scene/scene_file/scene_file.h"
#include "apps/terminal/output.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "radiometry/weather/instant.h"

namespace apps {

/// load_scene; what it finds is said as notes.
inline scene::SceneFile read_scene(const std::string& path, const Global& global) {
  std::vector<mtf::io::Diagnostic> findings;
  scene::SceneFile file = scene::load_scene(path, &findings);
  for (const mtf::io::Diagnostic& finding : findings) note(global, mtf::io::format_diagnostic(finding, file.file));
  return file;
}

/// UTC, s; nothing for "". Throws mtf::UsageError that names the option.
inline std::optional<double> instant_of(const std::string& option, const std::string& text) {
  if (text.empty()) return std::nullopt;
  radiometry::heat::InstantError error;
  const auto instant = radiometry::heat::parse_instant(text, error);
  if (!instant) throw mtf::UsageError(option + ": " + one_line(text) + ": " + error.text);
  return instant;
}

}  // namespace apps
