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
constexpr std::array<FieldInfo, 6> kLights{
    above(optional_row("photons", 0.0, kMost, "5200", "mean number at a pixel in an exposure")),
    above(optional_row("irradiance", 0.0, kMost, "0.02", "W/m^2 at the sensor, with wavelength in [light]")),
    optional_row("temperature", Dimension::temperature, "K", 1.0, 1e6, "\"308 K\"", "of a blackbody"),
    above(optional_row("radiance", 0.0, kMost, "45.0", "W m^-2 sr^-1 of a blackbody in the band of the nominal")),
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
constexpr FieldInfo kNonlinearity = optional_row("nonlinearity", 0, 3, "1", "terms of the response");

constexpr FieldInfo kLightStep = above(optional_row("step", Dimension::time, "s", 0.0, 1e9, "\"20 ms\"",
                                                    "from frame to frame, between two of which the light steps"));
constexpr FieldInfo kTrend = optional_row("trend", 0, 8, "2", "degree of the shading that is no part of PRNU");

constexpr FieldInfo kWidth = optional_row("width", 2, 1 << 30, "640", "pixels of a row"),
                    kHeight = optional_row("height", 2, 1 << 30, "512", "rows of a frame"),
                    kHeader = optional_row("header", 0, 1 << 30, "512", "bytes before the first frame"),
                    kStride = optional_row("stride", 0, 1 << 30, "1280", "bytes from row to row");
constexpr std::array<std::string_view, 3> kRawTypes{"uint8", "uint16le", "uint16be"};
constexpr FieldInfo kTemperatureSd = optional_row("temperature_sd", Dimension::temperature_difference, "K", 0.0, 1e6,
                                                  "\"20 mK\"", "standard deviation, of each blackbody");
constexpr FieldInfo kEmissivity = above(optional_row("emissivity", 0.0, 1.0, "0.98", "of the blackbodies"));
constexpr FieldInfo kEmissivitySd = optional_row("emissivity_sd", 0.0, 1.0, "0.005", "standard deviation of it");
constexpr FieldInfo kSurroundings = optional_row("surroundings", Dimension::temperature, "K", 0.0, 1e6, "\"295 K\"",
                                                 "temperature of what the blackbodies reflect");
constexpr FieldInfo kReference = optional_row("reference_temperature", Dimension::temperature, "K", 1.0, 1e6,
                                              "\"300 K\"", "at which SiTF and noise in kelvin hold");

template <std::size_t N>
void require_known(const Section& section, const std::array<std::string_view, N>& known) {
  cfg::check_keys(section, known);
}

/// Whether one name comes before another, with their numbers by value: f2 before f10, as cameras count frames.
bool is_before(std::string_view one, std::string_view other) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const std::string_view whole_one = one, whole_other = other;
  const auto take_number = [](std::string_view& text) {  // its digits without leading zeros, more of them being more
    const std::size_t end = std::min(text.find_first_not_of("0123456789"), text.size());
    std::string_view number = text.substr(0, end);
    number.remove_prefix(std::min(number.find_first_not_of('0'), end));
    text.remove_prefix(end);
    return std::pair(number.size(), number);
  };
  while (!one.empty() && !other.empty()) {
    if (is_digit(one.front()) && is_digit(other.front())) {
      const auto a = take_number(one), b = take_number(other);
      if (a != b) return a < b;
    } else {
      if (one.front() != other.front()) return one.front() < other.front();
      one.remove_prefix(1), other.remove_prefix(1);
    }
  }
  return one.size() != other.size() ? one.size() < other.size() : whole_one < whole_other;
}

/// The files of a pattern, in the order of is_before(); those without * or ? as they are.
std::vector<std::string> files_of_pattern(const std::string& pattern) {
  if (std::error_code none; std::filesystem::exists(pattern, none)) return {pattern};
  glob_t found{};
  std::vector<std::string> files;
  if (::glob(pattern.c_str(), 0, nullptr, &found) == 0) files.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  ::globfree(&found);
  std::ranges::sort(files, is_before);
  return files;
}

std::optional<RawLayout> read_raw(const Section& stack) {
  const Node* table = stack.find("raw");
  if (table == nullptr) return std::nullopt;
  const Section section{stack.reader, *table, stack.at("raw"), "raw"};
  if (table->kind != Node::Kind::table || !table->find("width") || !table->find("height") || !table->find("type"))
    stack.error("raw", "write raw = { width = 640, height = 512, type = \"uint16le\" }, or uint16be, uint8");
  if (table->kind != Node::Kind::table) return std::nullopt;
  require_known(section, std::array<std::string_view, 5>{"width", "height", "type", "header", "stride"});
  const auto type = cfg::read_word(section, "type", kRawTypes);
  const auto width = cfg::read_whole(section, kWidth), height = cfg::read_whole(section, kHeight);
  if (!type || !width || !height) return std::nullopt;
  const int bytes = *type == 0 ? 1 : 2, header = cfg::read_whole(section, kHeader).value_or(0);
  const std::int64_t row = std::int64_t{bytes} * *width, stride = cfg::read_whole(section, kStride).value_or(row);
  if (stride < row || stride % bytes != 0)
    section.error("stride", std::to_string(stride) + " bytes from row to row; " + std::to_string(*width) +
                                " pixels of " + std::string(kRawTypes[static_cast<std::size_t>(*type)]) + " take " +
                                std::to_string(row));
  constexpr std::array<const char*, 3> kNames{"|u1", "<u2", ">u2"};
  return RawLayout{.width = static_cast<std::uint64_t>(*width),
                   .height = static_cast<std::uint64_t>(*height),
                   .columns = static_cast<std::uint64_t>(stride / bytes),
                   .type = kNames[static_cast<std::size_t>(*type)],
                   .header = static_cast<std::uint64_t>(header)};
}

void read_stack(const Section& section, const FramesInMemory& memory, StacksFile& file) {
  require_known(section,
                std::array<std::string_view, 11>{"name", "frames", "raw", "step", "light", "photons", "irradiance",
                                                 "temperature", "radiance", "relative", "exposure"});
  StackEntry entry;
  const auto frames = cfg::read_string(section, "frames");
  if (!frames) {
    if (section.find("frames") == nullptr)
      section.error("frames", "missing; write frames = \"dark/*.png\", the files of the frames");
    return;
  }
  entry.name = cfg::read_string(section, "name").value_or(*frames);
  entry.raw = read_raw(section);
  const auto held = memory.find(*frames);
  if (held != memory.end())
    entry.memory = held->second;
  else
    entry.files = files_of_pattern(cfg::beside(section.reader.folder, *frames));
  if (held == memory.end() && entry.files.empty())
    section.error("frames", "there is no file " + *frames + "; names are relative to the folder of this file");
  if (const auto step = cfg::read_number(section, kLightStep, "step")) {
    for (const FieldInfo& light : kLights)
      if (section.find(light.name) != nullptr)
        return section.error(light.name, "of frames whose light steps; remove it, their means alone are read");
    if (std::ranges::any_of(file.stacks, [](const StackEntry& one) { return one.step_s > 0.0; }))
      return section.error("step", "there is another stack whose light steps; give one");
    entry.step_s = *step;
    file.stacks.push_back(std::move(entry));
    return;
  }
  std::array<std::optional<double>, kLights.size()> given;
  for (std::size_t k = 0; k < kLights.size(); ++k) given[k] = cfg::read_number(section, kLights[k], kLights[k].name);
  const auto& time = given[static_cast<std::size_t>(LightUnit::exposure)];
  entry.time_s = time.value_or(0.0);
  file.has_times = file.has_times && time;
  const Node* light = section.find("light");
  if (light != nullptr && light->kind != Node::Kind::boolean)
    return section.error("light", "write light = false for a dark stack; of others how much: photons = 5200");
  // One word on the light; the exposure time may stand beside it.
  std::vector<std::string_view> said;
  for (std::size_t k = 0; k < kLights.size(); ++k)
    if (given[k] && k != static_cast<std::size_t>(LightUnit::exposure)) said.push_back(kLights[k].name);
  const bool dark = light != nullptr && !light->boolean;
  if (said.size() > 1 || (dark && !said.empty()))
    return section.error(said.back(), "contradicts " + std::string(dark ? "light = false" : said.front()) +
                                          "; state the light in one way");
  if (!dark) {
    const auto first = std::find_if(given.begin(), given.end(), [](const auto& g) { return g.has_value(); });
    if (first == given.end())
      return section.error("light",
                           "how much light is not said; write photons, irradiance, temperature, relative or exposure, "
                           "or light = false");
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

/// What [light] says of blackbodies, which without them it must not.
Blackbodies read_blackbodies(const Section& light, const Section& options, const StacksFile& file) {
  Blackbodies bodies;
  const auto number = [&](const Section& section, const FieldInfo& info, bool belongs, const char* to) {
    if (!belongs && section.find(info.name) != nullptr)
      section.error(info.name, std::string("belongs to stacks by ") + to + "; remove it");
    return cfg::read_number(section, info, info.name);
  };
  const bool any = file.has_blackbodies(), temperatures = file.unit == LightUnit::temperature;
  const char *both = "temperature or radiance", *one = "temperature";
  bodies.temperature_sd_k = number(light, kTemperatureSd, any, both).value_or(bodies.temperature_sd_k);
  bodies.emissivity = number(light, kEmissivity, temperatures, one).value_or(bodies.emissivity);
  bodies.emissivity_sd = number(light, kEmissivitySd, temperatures, one).value_or(bodies.emissivity_sd);
  bodies.surroundings_k = number(light, kSurroundings, temperatures, one).value_or(bodies.surroundings_k);
  bodies.reference_k = number(options, kReference, any, both);
  if (any && light.find("repeatability") != nullptr)
    light.error("repeatability", "belongs to lamps; of blackbodies write temperature_sd");
  if (any && options.find("nonlinearity") != nullptr)
    options.error("nonlinearity", "belongs to photon transfer; counts are taken as linear in the radiance; remove it");
  return bodies;
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
  return parse_stacks(mtf::io::read_text_file(file, cfg::kMaxBytes), file);
}

StacksFile parse_stacks(const std::string& text, const std::string& file, const FramesInMemory& memory) {
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
  require_known(light, std::array<std::string_view, 6>{"repeatability", "wavelength", "temperature_sd", "emissivity",
                                                       "emissivity_sd", "surroundings"});
  require_known(options, std::array<std::string_view, 3>{"nonlinearity", "trend", "reference_temperature"});
  result.bits = cfg::read_whole(camera, kBits);
  result.step = cfg::read_number(camera, kStep, "step").value_or(1.0);
  result.full_well_e = cfg::read_number(camera, kFullWell, "full_well");
  result.repeatability = cfg::read_number(light, kRepeatability, "repeatability").value_or(0.0);
  result.wavelength_um = cfg::read_number(light, kWavelength, "wavelength");
  result.nonlinearity = cfg::read_whole(options, kNonlinearity).value_or(0);
  result.trend = cfg::read_whole(options, kTrend).value_or(2);
  const Node* stacks = cfg::find_tables(root, "stack");
  if (stacks == nullptr && tree.root.find("stack") == nullptr)
    reader.error({}, "stack", "missing; write [[stack]] with frames = \"dark/*.png\" for each exposure");
  for (std::size_t i = 0; stacks != nullptr && i < stacks->items.size(); ++i)
    read_stack({reader, stacks->items[i], "stack[" + std::to_string(i) + "]", "[[stack]]"}, memory, result);
  result.blackbodies = read_blackbodies(light, options, result);
  if (result.stacks.empty() && reader.diagnostics.empty())
    reader.error({}, "stack", "there is none; write [[stack]] with frames = \"dark/*.png\" for each exposure");
  const StackEntry* first = nullptr;
  for (const StackEntry& entry : result.stacks) {
    if (!result.has_blackbodies() || entry.step_s > 0.0) continue;
    if (first == nullptr) first = &entry;
    if (entry.time_s != first->time_s)
      reader.error({}, "stack",
                   entry.name + " has another exposure than " + first->name +
                       ": counts go by the radiance of blackbodies alone; give frames of one exposure");
    if (entry.light == 0.0)
      reader.error({}, "stack", entry.name + " has no light, others are of blackbodies; give all temperatures");
  }
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
