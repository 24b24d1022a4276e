// SPDX-License-Identifier: Apache-2.0
#pragma once

// The numbers of a 3-D scene's file that the page changes: weather, cloud, materials, what is inside of them (an engine
// bay), given temperatures: every row of apps/scene/scene_file/scene_sections.h whose value may be a number.

#include <span>
#include <string>
#include <vector>

#include "apps/live/edits.h"
#include "apps/live/model.h"
#include "apps/scene/scene_file/scene_file.h"
#include "mtf/component.h"
#include "mtf/io/config/config_tree.h"

namespace apps::live {

/// One number. `node` and `table` are of the tree that it was made from.
struct SceneRow {
  std::string name;  ///< "material.engine_deck.inside.temperature"
  std::string key;   ///< "inside temperature"
  mtf::FieldInfo field;
  const mtf::io::cfg::Node* table = nullptr;  ///< that has the key
  const mtf::io::cfg::Node* node = nullptr;   ///< its value; null where the file does not state it
  std::string otherwise{};                    ///< what counts then
};

struct SceneTable {
  std::string title;  ///< "weather", "material engine_deck"
  std::string doc;
  std::vector<SceneRow> rows;
};

/// Tables without a number are left out. Constant weather has the values that the file states, weather of a file what
/// changes its records.
std::vector<SceneTable> scene_tables(const mtf::io::cfg::Node& root);

/// {"tables": [{"name", "doc", "fixed": true, "rows": [...]}]}, rows as those of model_json.
Json scene_json(const std::string& text);

/// The text of the scene file with these edits, of Edit::Kind::set and unset; comments and all else stay. A
/// value that is no number is refused unless it is the one that `start`, the text at the start, has there: no edit
/// names another file. `file`: of the scene, for messages and for what it names. Throws RefusedEdit of the list
/// "scene".
std::string edited_scene(const std::string& start, const std::string& file, std::span<const Edit> edits);

}  // namespace apps::live
