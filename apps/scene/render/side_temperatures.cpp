// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/render/side_temperatures.h"

#include <algorithm>
#include <filesystem>
#include <limits>

#include "apps/scene/heat/npy_rows.h"
#include "apps/scene/heat/read_facet_table.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

namespace fs = std::filesystem;
namespace heat = radiometry::heat;

/// Fronts, and the backs of sheets where they are known.
struct FacetTemperatures {
  std::vector<float> front, back;
};

/// Rows of a folder, of which the two about the last time stay in memory.
class FolderRows {
 public:
  FolderRows(const std::string& folder, std::size_t facets) : front_(folder + "/temperatures.npy") {
    times_ = read_output_times(folder + "/times.csv", front_.rows());
    const std::string back = folder + "/temperatures_back.npy";
    std::error_code ignored;
    if (fs::exists(back, ignored)) back_.emplace(back);
    for (const NpyRows* table : {&front_, back_ ? &*back_ : nullptr})
      if (table != nullptr && table->columns() != facets)
        throw mtf::UsageError(one_line(folder) + ": has " + std::to_string(table->columns()) + " facets, the scene " +
                              std::to_string(facets) + "; it belongs to another scene");
  }
  const std::vector<double>& times() const { return times_; }
  const FacetTemperatures& row(std::size_t i) {
    Known& known = known_[i % known_.size()];
    if (known.row != i) {
      known.values = {front_.row(i), back_ ? back_->row(i) : std::vector<float>()};
      known.row = i;
    }
    return known.values;
  }

 private:
  struct Known {
    std::size_t row = static_cast<std::size_t>(-1);
    FacetTemperatures values{};
  };
  NpyRows front_;
  std::optional<NpyRows> back_{};
  std::vector<double> times_{};
  std::array<Known, 2> known_{};
};

void mix(const std::vector<float>& a, const std::vector<float>& b, double share, std::vector<float>& out) {
  out.resize(a.size());
  for (std::size_t f = 0; f < a.size(); ++f)
    out[f] = static_cast<float>((1.0 - share) * static_cast<double>(a[f]) + share * static_cast<double>(b[f]));
}

}  // namespace

struct SideTemperatures::State {
  double start_s;
  std::string source;
  std::vector<Region> regions;
  std::vector<std::uint32_t> region;
  std::vector<bool> solid;  ///< of each facet: its back is the inside of a solid
  std::optional<FolderRows> folder{};
  HeatRows rows{};
  std::optional<FacetTable> table{};
  FacetTemperatures now{};

  State(const ThermalScene& scene, std::string from)
      : start_s(scene.start_s), source(std::move(from)), regions(scene.regions), region(scene.region_of) {
    const radiometry::scene::Facets& facets = scene.facets;
    for (std::uint32_t f = 0; f < facets.size(); ++f)
      solid.push_back(facets.shells[facets.facet[f].shell].outward && !is_sheet(scene, f));
  }

  const std::vector<double>& times() const { return folder ? folder->times() : rows.utc_s; }
  void require_time(double utc_s) const;
  void from_rows(double utc_s);
  void from_file(double utc_s);
  void require_all() const;
};

void SideTemperatures::State::require_time(double utc_s) const {
  const std::vector<double>& time = times();
  if (time.empty() || (utc_s >= time.front() && utc_s <= time.back())) return;
  throw mtf::UsageError(heat::instant_text(utc_s) + " is outside of the temperatures of " + one_line(source) +
                        ", which go from " + heat::instant_text(time.front()) + " to " +
                        heat::instant_text(time.back()));
}

void SideTemperatures::State::from_rows(double utc_s) {
  require_time(utc_s);
  const std::vector<double>& time = times();
  const auto above = std::upper_bound(time.begin(), time.end(), utc_s);
  const std::size_t row = static_cast<std::size_t>(above - time.begin()) - 1;
  const std::size_t next = std::min(row + 1, time.size() - 1);
  const double share = next == row ? 0.0 : (utc_s - time[row]) / (time[next] - time[row]);
  if (folder) {
    const FacetTemperatures &a = folder->row(row), &b = folder->row(next);
    mix(a.front, b.front, share, now.front);
    mix(a.back, b.back, share, now.back);
  } else {
    mix(rows.front[row], rows.front[next], share, now.front);
    mix(rows.back[row], rows.back[next], share, now.back);
  }
}

void SideTemperatures::State::from_file(double utc_s) {
  now.front.resize(region.size());
  for (std::uint32_t f = 0; f < region.size(); ++f)
    now.front[f] = static_cast<float>(table ? table->at(f, utc_s) : regions[region[f]].given_k(f, utc_s));
}

void SideTemperatures::State::require_all() const {
  std::vector<std::size_t> unknown(regions.size(), 0);
  for (std::size_t f = 0; f < region.size(); ++f)
    if (!(now.front[f] > 0.0F)) ++unknown[region[f]];
  std::string missing;
  for (std::size_t r = 0; r < unknown.size(); ++r)
    if (unknown[r] > 0)
      missing +=
          (missing.empty() ? "'" : ", '") + one_line(regions[r].name) + "' (" + std::to_string(unknown[r]) + " facets)";
  if (!missing.empty())
    throw mtf::UsageError(one_line(source) + ": has no temperature for facets of the regions " + missing);
}

SideTemperatures::SideTemperatures(const ThermalScene& scene, const std::string& source)
    : state_(std::make_unique<State>(scene, source.empty() ? scene.name : source)) {
  std::error_code ignored;
  const std::size_t facets = scene.facets.size();
  if (fs::is_directory(source, ignored))
    state_->folder.emplace(source, facets);
  else if (!source.empty())
    state_->table = read_facet_table(source, facets);
}

SideTemperatures::SideTemperatures(const ThermalScene& scene, HeatRows rows)
    : state_(std::make_unique<State>(scene, scene.name)) {
  state_->rows = std::move(rows);
}

SideTemperatures::~SideTemperatures() = default;
SideTemperatures::SideTemperatures(SideTemperatures&&) noexcept = default;

double SideTemperatures::default_utc_s() const {
  return state_->times().empty() ? state_->start_s : state_->times().back();
}

std::optional<std::array<double, 2>> SideTemperatures::span_utc_s() const {
  if (state_->times().empty()) return std::nullopt;
  return std::array{state_->times().front(), state_->times().back()};
}

void SideTemperatures::require_time(double utc_s) const { state_->require_time(utc_s); }

bool SideTemperatures::change() const {
  const State& state = *state_;
  if (!state.times().empty()) return state.times().size() > 1;
  if (state.table) return state.table->time_s.size() > 1;
  return std::ranges::any_of(state.regions, [](const Region& region) {
    return region.table != nullptr || (region.is_given() && !region.temperature.constant());
  });
}

void SideTemperatures::at(double utc_s, std::vector<float>& kelvin) {
  State& state = *state_;
  if (state.times().empty())
    state.from_file(utc_s);
  else
    state.from_rows(utc_s);
  state.require_all();
  const std::vector<float>&front = state.now.front, &back = state.now.back;
  kelvin.resize(2 * front.size());
  for (std::size_t f = 0; f < front.size(); ++f) {
    kelvin[2 * f] = front[f];
    kelvin[2 * f + 1] = state.solid[f]                      ? std::numeric_limits<float>::quiet_NaN()
                        : back.empty() || !(back[f] > 0.0F) ? front[f]
                                                            : back[f];
  }
}

std::vector<std::string> temperature_files(const std::string& source) {
  if (source.empty()) return {};
  std::error_code ignored;
  const bool folder = fs::is_directory(source, ignored);
  const fs::path beside = folder ? fs::path(source) : fs::path(source).parent_path();
  std::vector<std::string> files{(beside / "times.csv").string()};
  if (!folder) files.push_back(source);
  if (folder)
    for (const char* name : {"temperatures.npy", "temperatures_back.npy"}) files.push_back((beside / name).string());
  return files;
}

bool is_sheet(const ThermalScene& scene, std::uint32_t facet) {
  const auto& material = scene.regions[scene.region_of[facet]].material;
  return material && scene.materials[*material].is_sheet();
}

std::string regions_to_solve(const SceneFile& file) {
  std::string missing;
  for (const RegionSection& region : file.regions)
    if (!region.temperature) missing += (missing.empty() ? "'" : ", '") + one_line(region.name) + "'";
  return missing;
}

}  // namespace apps::scene
