// SPDX-License-Identifier: Apache-2.0
#pragma once

// The numbers of a 3-D scene's file that the page changes: weather, cloud, materials, what is inside of them (an engine
// bay), given temperatures: every row of apps/scene/scene_file/scene_sections.h whose value may be a number.

#include <span>
#include <string>

#include "apps/live/edits.h"

namespace apps::live {

/// {"tables": [{"name", "doc", "fixed": true, "rows": [...]}]}, rows as those of model_json.
Json scene_json(const std::string& text);

/// The text of the scene file with these edits, of Edit::Kind::set and unset; comments and all else stay. A
/// value that is no number is refused unless it is the one that `start`, the text at the start, has there: no edit
/// names another file. `file`: of the scene, for messages and for what it names. Throws RefusedEdit of the list
/// "scene".
std::string edited_scene(const std::string& start, const std::string& file, std::span<const Edit> edits);

}  // namespace apps::live
