// SPDX-License-Identifier: Apache-2.0
#include "apps/characterize/stacks_file.h"

#include <glob.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>

#include "apps/characterize/emva_descriptor.h"
#include "mtf/components/field.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/io/sha256.h"

namespace apps {
namespace {

namespace cfg = mtf::io::cfg;
using cfg::Node, cfg::Section;
using mtf::above, mtf::Dimension, mtf::FieldInfo, mtf::optional_row;

constexpr double kMost = 1e300;
constexpr std::array<FieldInfo, 4> kLights{
    above(optional_row("photons", 0.0, kMost, "5200", "mean number at a pixel in an exposure")),
    above(optional_row("irradiance", 0.0, kMost, "0.02", "W/m^2 at the sensor, with wavelength in [light]")),
    above(optional_row("relative", 0.0, kMost, "3.0", "light in an exposure, in any unit")),
    above(optional_row("exposure", Dimension::time, "s", 0.0, 1e9, "\"10 ms\"", "exposure time of a frame"))};
constexpr FieldInfo kBits = optional_row("bits", 1, 31, "12", "bits of a count");
constexpr FieldInfo kStep = optional_row("step", 1.0, 32768.0, "16", "of stored values, where they are shifted");
constexpr FieldInfo kFullWell = above(
    optional_row("full_well", Dimension::electrons, "e-", 0.0, 1e15, "\"20 ke-\"", "to which nonlinearity refers"));
constexpr FieldInfo kRepeatability =
    optional_row("repeatability", 0.0, 1.0, "0.002", "relative sd of the light from stack to stack");
constexpr FieldInfo kWavelength =
    above(optional_row("wavelength", Dimension::length, "um", 0.0, 1e4, "\"530 nm\"", "of the light"));
constexpr FieldInfo kNonlinearity = optional_row("nonlinearity", 0, 2, "1", "terms of the response");

template <std::size_t N>
void require_known(const Section& section, const std::array<std::string_view, N>& known) {
  cfg::check_keys(section, known);
}

/// The files of a pattern, by their names; those without * or ? as they are.
std::vector<std::string> files_of_pattern(const std::string& pattern) {
  if (std::error_code none; std::filesystem::exists(pattern, none)) return {pattern};
  glob_t found{};
  std::vector<std::string> files;
  if (::glob(pattern.c_str(), 0, nullptr, &found) == 0) files.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  ::globfree(&found);
  return files;
}

void read_stack(const Section& section, StacksFile& file) {
  require_known(section, std::array<std::string_view, 7>{"name", "frames", "light", "photons", "irradiance", "relative",
                                                         "exposure"});
  StackEntry entry;
  const auto frames = cfg::read_string(section, "frames");
  if (!frames) {
    if (section.find("frames") == nullptr)
      section.error("frames", "missing; write frames = \"dark/*.png\", the files of the frames");
    return;
  }
  entry.name = cfg::read_string(section, "name").value_or(*frames);
  entry.files = files_of_pattern(cfg::beside(section.reader.folder, *frames));
  if (entry.files.empty())
    section.error("frames", "there is no file " + *frames + "; names are relative to the folder of this file");
  std::array<std::optional<double>, kLights.size()> given;
  for (std::size_t k = 0; k < kLights.size(); ++k) given[k] = cfg::read_number(section, kLights[k], kLights[k].name);
  const auto& time = given[static_cast<std::size_t>(LightUnit::exposure)];
  entry.time_s = time.value_or(0.0);
  file.has_times = file.has_times && time;
  const Node* light = section.find("light");
  if (light != nullptr && light->kind != Node::Kind::boolean)
    return section.error("light", "write light = false for a dark stack; of others how much: photons = 5200");
  if (light == nullptr || light->boolean) {
    const auto first = std::find_if(given.begin(), given.end(), [](const auto& g) { return g.has_value(); });
    if (first == given.end())
      return section.error("light",
                           "how much light is not said; write photons, irradiance, relative or exposure, or "
                           "light = false");
    const auto unit = static_cast<LightUnit>(first - given.begin());
    const bool known = std::any_of(file.stacks.begin(), file.stacks.end(), [](const auto& s) { return s.light > 0.0; });
    if (known && unit != file.unit)
      return section.error(name_of(unit), "the light of other stacks is in " + std::string(name_of(file.unit)) +
                                              "; state that of all in one way");
    if (unit == LightUnit::irradiance && !time)
      return section.error("exposure", "missing; irradiance gives photons with the exposure time");
    file.unit = unit;
    entry.light = **first;
  }
  file.stacks.push_back(std::move(entry));
}

/// The table of that name; an empty one where the file has none.
Section table_of(const Section& root, std::string_view key) {
  static const Node kEmpty{};
  const Node* table = cfg::find_table(root, key);
  return {root.reader, table != nullptr ? *table : kEmpty, std::string(key), "[" + std::string(key) + "]"};
}

}  // namespace

std::string_view name_of(LightUnit unit) { return kLights[static_cast<std::size_t>(unit)].name; }

StacksFile load_stacks(const std::string& file) {
  if (is_emva_descriptor(file)) return load_emva_descriptor(file);
  const std::string text = mtf::io::read_text_file(file, cfg::kMaxBytes);
  StacksFile result{.file = file, .sha256 = mtf::io::sha256_hex(text)};
  const cfg::Tree tree = cfg::read_tree(text);
  if (tree.error) cfg::require_no_errors({*tree.error}, file);
  cfg::Reader reader{
      .folder = cfg::folder_of(file), .schema = {}, .diagnostics = {}, .positions = {}, .failed = {}, .fits = {}};
  const Section root{reader, tree.root, "", ""};
  require_known(root, std::array<std::string_view, 6>{"schema", "nominal", "camera", "stack", "light", "options"});
  static_cast<void>(cfg::read_whole(root, optional_row("schema", 1, 1, "1", "version of this file")));
  if (const auto nominal = cfg::read_string(root, "nominal")) result.nominal = cfg::beside(reader.folder, *nominal);
  const Section camera = table_of(root, "camera"), light = table_of(root, "light"), options = table_of(root, "options");
  require_known(camera, std::array<std::string_view, 3>{"bits", "step", "full_well"});
  require_known(light, std::array<std::string_view, 2>{"repeatability", "wavelength"});
  require_known(options, std::array<std::string_view, 1>{"nonlinearity"});
  result.bits = cfg::read_whole(camera, kBits);
  result.step = cfg::read_number(camera, kStep, "step").value_or(1.0);
  result.full_well_e = cfg::read_number(camera, kFullWell, "full_well");
  result.repeatability = cfg::read_number(light, kRepeatability, "repeatability").value_or(0.0);
  result.wavelength_um = cfg::read_number(light, kWavelength, "wavelength");
  result.nonlinearity = cfg::read_whole(options, kNonlinearity).value_or(0);
  const Node* stacks = cfg::find_tables(root, "stack");
  if (stacks == nullptr && tree.root.find("stack") == nullptr)
    reader.error({}, "stack", "missing; write [[stack]] with frames = \"dark/*.png\" for each exposure");
  for (std::size_t i = 0; stacks != nullptr && i < stacks->items.size(); ++i)
    read_stack({reader, stacks->items[i], "stack[" + std::to_string(i) + "]", "[[stack]]"}, result);
  // Frames that count twice look better than they are.
  std::map<std::filesystem::path, std::string> seen;
  for (const StackEntry& entry : result.stacks)
    for (const std::string& one : entry.files) {
      const auto [place, fresh] = seen.emplace(std::filesystem::weakly_canonical(one), entry.name);
      if (!fresh) {
        reader.error({}, "stack", one + " is in two stacks, " + place->second + " and " + entry.name);
        break;
      }
    }
  if (result.unit == LightUnit::irradiance && !result.wavelength_um)
    reader.error({}, "light.wavelength", "missing; irradiance gives photons by the wavelength of the light");
  cfg::sort_diagnostics(reader.diagnostics);
  cfg::require_no_errors(reader.diagnostics, file);
  return result;
}

}  // namespace apps
