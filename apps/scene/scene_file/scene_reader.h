// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reading a scene file, part by part: what the parts share. As with sensor files nothing throws for what is in the
// text; everything wrong is collected with its place.

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "apps/scene/scene_file/scene_fields.h"
#include "apps/scene/scene_file/scene_file.h"
#include "mtf/io/config/config_reader.h"

namespace apps::scene {

struct SceneReader {
  mtf::io::cfg::Reader reader;
  mtf::io::cfg::Node tree{};
  SceneFile scene{};
  std::vector<std::string_view> material_names{}, mesh_names{};  ///< of the tables, "" where the name is missing
  std::set<std::string, std::less<>> used_materials{}, used_meshes{};

  mtf::io::cfg::Section root() { return {reader, tree, "", ""}; }
};

/// The value of `field.name` in `field.unit` ("" for plain numbers), which is in the range of `field`; `field.example`
/// is a value as written. A table { value, fit, min, max, prior, stderr } leaves a FitSpec. Reports a missing required
/// one.
std::optional<double> read_si(const mtf::io::cfg::Section& section, const mtf::FieldInfo& field);

/// A fit table; its value when usable. In scene_fits.cpp.
std::optional<double> read_marked(const mtf::io::cfg::Section& section, const mtf::io::cfg::Node& table,
                                  const mtf::FieldInfo& field, const std::string& path);
/// A number or a string with its unit, no table.
std::optional<double> read_plain_si(const mtf::io::cfg::Section& section, const mtf::io::cfg::Node& node,
                                    const mtf::FieldInfo& field, const std::string& path);

/// A table `key` of the file, which has to be there if `remedy` is not empty; reports what is wrong.
const mtf::io::cfg::Node* find_section(SceneReader& s, std::string_view key, std::string_view remedy);
/// The list of tables [[key]]; null when absent, and when it is none (reported).
const mtf::io::cfg::Node* find_tables(SceneReader& s, std::string_view key);

/// The name of a table that others refer to by it, such as `example`; joins `names`, "" where it is missing or wrong.
std::string read_name(const mtf::io::cfg::Section& section, std::vector<std::string_view>& names,
                      std::string_view example);

/// The path of a file that `key` names, against the folder of the scene file; null when absent or reported.
std::optional<std::string> read_path(const mtf::io::cfg::Section& section, std::string_view key);

/// A constant "80 degC" or the name of a schedule "engine.csv" (a name that ends in .csv), in the range of `field`.
std::optional<radiometry::heat::Schedule> read_schedule_value(SceneReader& s, const mtf::io::cfg::Section& section,
                                                              const mtf::FieldInfo& field);
/// The same, or the path of a table of facets.
std::optional<GivenTemperature> read_given_temperature(SceneReader& s, const mtf::io::cfg::Section& section);

/// A number, or the name of a file with bands or a spectrum.
std::optional<Emissivity> read_emissivity(const mtf::io::cfg::Section& section, std::string_view key);

/// A list of three lengths.
std::optional<std::array<double, 3>> read_point(const mtf::io::cfg::Section& section, std::string_view key);

/// Index of a name among those defined; reports an unknown one with the nearest.
std::optional<std::size_t> read_reference(const mtf::io::cfg::Section& section, std::string_view key,
                                          const std::vector<std::string_view>& names, std::string_view what);

/// [place], [time], [weather], [sky].
void read_place(SceneReader& s);
void read_time(SceneReader& s);
void read_weather_section(SceneReader& s);
void read_sky(SceneReader& s);
/// [[material]].
void read_materials(SceneReader& s);
/// Whether the file has [ground] and neither meshes nor regions.
bool is_ground_alone(const SceneReader& s);
/// [[mesh]], [[region]], [ground], [measured], [camera].
void read_meshes(SceneReader& s);
void read_regions(SceneReader& s);
void read_ground(SceneReader& s);
void read_measured(SceneReader& s);
void read_camera(SceneReader& s);

/// A schedule has to stay within the range of a field; the value that does not, in words.
std::optional<std::string> out_of_range(const radiometry::heat::Schedule& schedule, const mtf::FieldInfo& field,
                                        double origin_s);

}  // namespace apps::scene
