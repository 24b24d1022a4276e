// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/command/heat_files.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <type_traits>

#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/error.h"
#include "mtf/io/atomic_file.h"
#include "mtf/io/sha256.h"
#include "mtf/version.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {
namespace {

namespace heat = radiometry::heat;

constexpr const char* kEvaporation = "bulk, w h / gamma (e_s(T) - e), h of the wind, FAO-56 gamma, Magnus over water";

Json closures(const SceneFile& file, const HeatScene& scene) {
  Json materials = Json::array();
  for (std::size_t i = 0; i < file.materials.size(); ++i) {
    const Material& material = scene.material[i];
    materials.push_back({{"material", material.name},
                         {"convection", name_of(material.construction.convection)},
                         {"inside", kInsideNames.at(static_cast<std::size_t>(file.materials[i].inside.kind))},
                         {"solar_absorptance", material.solar_absorptance},
                         {"emissivity", material.construction.emissivity},
                         {"evaporation", material.construction.is_wet() ? kEvaporation : "none"},
                         {"wet_fraction", material.construction.wet_fraction}});
  }
  const std::optional<GroundSection>& ground = file.ground;
  return {{"materials", materials},
          {"sky_longwave", kLongwaveNames.at(static_cast<std::size_t>(file.sky.longwave))},
          {"cloud", kCloudNames.at(static_cast<std::size_t>(file.sky.cloud))},
          {"sky_radiance", "isotropic"},
          {"sun", "point, visibility linear in time between the directions of the table"},
          {"ground", !ground               ? "black, at the temperature of the air"
                     : ground->temperature ? "of given temperature"
                                           : "solved"},
          {"left_out", {"conduction along surfaces", "drying and wetting", "half shadow of the sun's disc"}}};
}

Json promise(const heat::Promise& promised) {
  return {{"steps_K", promised.steps_k},
          {"grid_K", promised.grid_k},
          {"depth_K", promised.depth_k},
          {"start_K", promised.start_k}};
}

Json error_json(const radiometry::scene::TableError& error) {
  return {{"rms", error.rms}, {"percentile_95", error.percentile_95}, {"count", error.count}};
}

/// null where all facets are asked for.
Json seen_json(const HeatReport& report) {
  if (!report.left_out) return nullptr;
  return {{"facets", report.facets - report.left_out->facets},
          {"facets_left_out", report.left_out->facets},
          {"classes_left_out", report.left_out->units},
          {"error_K",
           {{"rms", report.left_out->error_k.rms},
            {"percentile_95", report.left_out->error_k.percentile_95},
            {"largest", report.left_out->largest_k},
            {"count", report.left_out->error_k.count}}}};
}

Json realised_json(const HeatScene& scene, const RealisedError& error) {
  return {{"rms_K", error.rms_k},
          {"percentile_95_K", error.percentile_95_k},
          {"percentile_99_9_K", error.percentile_999_k},
          {"largest_K", error.largest_k},
          {"facet", error.facet},
          {"time", heat::instant_text(scene.input.start_s + error.time_s)},
          {"count", error.count},
          {"truth_promises_K", error.promised_k}};
}

/// null where it was not asked for.
Json verified_json(const HeatScene& scene, const HeatReport& report) {
  if (!report.verified) return nullptr;
  return {{"as_classes", realised_json(scene, report.verified->as_units)},
          {"each_facet", realised_json(scene, report.verified->by_itself)}};
}

namespace heat = radiometry::heat;

class Writer {
 public:
  template <class... T>
  void operator()(const T&... values) {
    (add(values), ...);
  }
  template <class T>
  void add(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <class T>
  void add(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    add(values.size());
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  void add(const std::string& text) {
    add(text.size());
    bytes_.append(text);
  }
  /// How many of something follow.
  std::size_t count(std::size_t size, std::size_t) {
    add(size);
    return size;
  }
  std::string& bytes() { return bytes_; }

 private:
  std::string bytes_;
};

class Reader {
 public:
  explicit Reader(std::string_view bytes) : left_(bytes) {}
  template <class... T>
  void operator()(T&... values) {
    (take_into(values), ...);
  }
  template <class T>
  void take_into(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::memcpy(&value, take(1, sizeof value), sizeof value);
  }
  template <class T>
  void take_into(std::vector<T>& values) {
    const std::size_t size = count(0);
    const char* from = take(size, sizeof(T));
    values.resize(size);
    if (size > 0) std::memcpy(values.data(), from, size * sizeof(T));
  }
  void take_into(std::string& text) {
    const std::size_t size = count(0);
    text.assign(take(size, 1), size);
  }
  std::size_t count(std::size_t) {
    std::size_t size = 0;
    take_into(size);
    return size;
  }
  /// The same of things of at least that many bytes.
  std::size_t count(std::size_t, std::size_t bytes) {
    const std::size_t size = count(0);
    if (size > left_.size() / bytes) damaged();
    return size;
  }
  bool at_end() const { return left_.empty(); }
  [[noreturn]] static void damaged() { damaged_checkpoint(); }

 private:
  const char* take(std::size_t count, std::size_t size) {
    if (count > left_.size() / size) damaged();
    const char* from = left_.data();
    left_.remove_prefix(count * size);
    return from;
  }
  std::string_view left_;
};

template <class Archive, class Grid>
void grid(Archive& a, Grid& g) {
  a(g.capacity, g.conductance, g.depth_m, g.layer_m, g.inner_w_m2_k);
}

template <class Archive, class State>
void state(Archive& a, State& s) {
  a(s.time_s, s.facets, s.fine, s.doubled, s.coarse, s.step_s);
}

template <class Archive, class Batch>
void batch(Archive& a, Batch& b) {
  a(b.wanted_k, b.run.name, b.run.units, b.run.sample, b.run.nodes, b.run.promised, b.run.steps, b.run.drift);
  grid(a, b.fine);
  grid(a, b.coarse);
  a(b.request, b.step_tolerance_k, b.depth_k);
  for (auto* each : {&b.all, &b.sample, &b.promise}) state(a, *each);
}

/// All of it, whichever way.
template <class Archive, class Saved>
void all_of(Archive& a, Saved& c) {
  a(c.windows, c.outputs, c.exchange_k, c.left_out, c.warmest_k, c.iterations, c.view_spread);
  a(c.batches.window, c.batches.emitted, c.batches.beyond_sample);
  constexpr std::size_t kLeast = 256;  // bytes of a batch
  const std::size_t count = a.count(c.batches.batch.size(), kLeast);
  if constexpr (!std::is_const_v<Saved>) c.batches.batch.resize(count);
  for (auto& one : c.batches.batch) batch(a, one);
}

template <class... Vectors>
std::string hash_of(const Vectors&... vectors) {
  Writer bytes;
  bytes(vectors...);
  return mtf::io::sha256_hex(bytes.bytes());
}

std::string hash_of_tables(const ThermalScene& scene) {
  std::string hashes;
  for (const heat::Schedule* schedule : scene.schedules()) hashes += hash_of(schedule->time_s, schedule->value);
  for (const Material& material : scene.materials) hashes += hash_of(material.source_w_m2, material.back_source_w_m2);
  for (const Region& region : scene.regions)
    if (region.table) hashes += hash_of(region.table->utc_s, region.table->front_k);
  return mtf::io::sha256_hex(hashes);
}

/// As bytes of this machine, and back; throws RuntimeError for bytes that are none.
std::string bytes_of(const Checkpoint& checkpoint) {
  Writer writer;
  all_of(writer, checkpoint);
  return std::move(writer.bytes());
}

Checkpoint checkpoint_of(std::string_view bytes) {
  Reader reader(bytes);
  Checkpoint checkpoint;
  all_of(reader, checkpoint);
  if (!reader.at_end()) Reader::damaged();
  return checkpoint;
}

constexpr std::string_view kMagic = "mtf heat, unfinished\n";

[[noreturn]] void refuse(const std::string& folder, const std::string& why) {
  throw mtf::UsageError(one_line(folder) + " holds a run that was interrupted, " + why +
                        "; --anew begins again and replaces it");
}

/// JSON has no NaN: that of a region that the camera does not see is null.
double kelvin_of(const Json& number) {
  return number.is_null() ? std::numeric_limits<double>::quiet_NaN() : number.get<double>();
}

}  // namespace

std::string heat_json(const SceneFile& file, const HeatScene& scene, const HeatReport& report,
                      const HeatOptions& options) {
  Json materials = Json::array();
  double residual = 0.0;
  std::int64_t steps = 0;
  for (const MaterialRun& run : report.materials) {
    materials.push_back({{"material", run.name},
                         {"classes", run.units},
                         {"nodes", run.nodes},
                         {"promised", promise(run.promised)},
                         {"facet_steps", run.steps.facet_steps},
                         {"steps_refused", run.steps.refused},
                         {"residual_K", run.promised.start_k},
                         {"energy_drift", run.drift}});
    residual = std::max(residual, run.promised.start_k);
    steps += run.steps.facet_steps;
  }
  const HeatPromise& p = report.promised;
  const Json json = {{"scene", file.file},
                     {"scene_sha256", file.sha256},
                     {"version", mtf::version},
                     {"commit", mtf::git_commit},
                     {"start", heat::instant_text(file.time.start_s)},
                     {"end", heat::instant_text(file.time.end_s)},
                     {"outputs", report.outputs},
                     {"finished", report.outputs == scene.surroundings.outputs.size()},
                     {"facets", report.facets},
                     {"classes", report.units},
                     {"patches", report.patches},
                     {"covered_facets", Json::object(covered_by_region(scene, report))},
                     {"seen", seen_json(report)},
                     {"steps", steps},
                     {"tolerance_K", options.tolerance_k},
                     {"promised_K", p.total_k()},
                     {"promised",
                      {{"solver", promise(p.solver)},
                       {"ground_K", p.ground_k},
                       {"classes_K", p.units_k},
                       {"exchange_K", p.exchange_k},
                       {"feedback", p.feedback}}},
                     {"realised", verified_json(scene, report)},
                     {"residual_K", residual},
                     {"exchange_iterations", report.iterations},
                     {"tables",
                      {{"sun_directions", scene.surroundings.shadow_to_sun.size()},
                       {"sun_points", options.sun_points},
                       {"sun_share_error", error_json(report.sun_error.of_directions)},
                       {"sun_share_error_of_facets", error_json(report.sun_error.of_sides)},
                       {"view_rays", options.rays_of(report.facets)},
                       {"sky_share_error", error_json(report.view_error.sky)},
                       {"surfaces_share_error", error_json(report.view_error.surfaces)},
                       {"view_of_facets_against_classes_K",
                        {{"rms", report.view_spread.error_k.rms},
                         {"percentile_95", report.view_spread.error_k.percentile_95},
                         {"largest", report.view_spread.largest_k},
                         {"count", report.view_spread.error_k.count}}}}},
                     {"closures", closures(file, scene)},
                     {"materials", materials},
                     {"timing_ms", Json::object(report.timing_ms)},
                     {"warnings", report.warnings}};
  return json_document(json);
}

std::vector<RegionTemperature> region_temperatures(const HeatScene& scene, std::span<const double> facet_k) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<RegionTemperature> regions(scene.input.regions.size(), {kInfinity, 0.0, -kInfinity});
  std::vector<double> area_m2(regions.size(), 0.0);
  for (std::size_t f = 0; f < facet_k.size(); ++f) {
    if (std::isnan(facet_k[f])) continue;  // not asked for
    const double area = scene.facets().facet[f].area_m2;
    RegionTemperature& region = regions[scene.input.region_of[f]];
    region.least_k = std::min(region.least_k, facet_k[f]);
    region.most_k = std::max(region.most_k, facet_k[f]);
    region.mean_k += area * facet_k[f];
    area_m2[scene.input.region_of[f]] += area;
  }
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t r = 0; r < regions.size(); ++r) {
    regions[r].mean_k /= area_m2[r];
    if (area_m2[r] == 0.0) regions[r] = {kUnknown, kUnknown, kUnknown};
  }
  return regions;
}

HeatFiles::HeatFiles(std::string folder, std::string kept, const SceneFile& file, const HeatScene& scene)
    : folder_(std::move(folder)),
      kept_(std::move(kept)),
      file_(file),
      scene_(scene),
      front_(std::make_unique<NpyFile>(at("temperatures.npy"), scene.facets().size())) {
  for (std::uint32_t f = 0; f < scene.facets().size() && !back_; ++f)
    if (scene.is_sheet(f)) back_ = std::make_unique<NpyFile>(at("temperatures_back.npy"), scene.facets().size());
}

void HeatFiles::take_over(const EarlierOutputs& earlier) {
  const std::size_t outputs = earlier.times_s.size();
  // Without second names of files only Ctrl-C leaves an unfinished run, with all that is finished in place.
  const auto table = [&](const std::string& kept, const std::string& own) {
    return kept_ + "/" + (std::filesystem::exists(kept_ + "/" + kept) ? kept : own);
  };
  copy_rows(table("unfinished.npy", "temperatures.npy"), outputs, *front_);
  if (back_) copy_rows(table("unfinished_back.npy", "temperatures_back.npy"), outputs, *back_);
  times_s_ = earlier.times_s;
  regions_ = earlier.regions;
}

std::string HeatFiles::instant(double time_s) const {
  return radiometry::heat::instant_text(file_.time.start_s + time_s);
}

void HeatFiles::append(const HeatOutput& output) {
  front_->append(std::vector<float>(output.front_k.begin(), output.front_k.end()));
  if (back_) back_->append(std::vector<float>(output.back_k.begin(), output.back_k.end()));
  regions_.push_back(region_temperatures(scene_, output.front_k));
  times_s_.push_back(output.time_s);
}

bool HeatFiles::keep() {
  return front_->keep_as(kept_ + "/unfinished.npy") && (!back_ || back_->keep_as(kept_ + "/unfinished_back.npy"));
}

std::vector<std::string> heat_names() {
  return {"temperatures.npy", "temperatures_back.npy", "facets.csv", "times.csv",  "regions.csv", "heat.json",
          "regions.svg",      "regions.svg.csv",       "scene.png",  "facets.ply", "facets.vtk",  "sensitivity.csv"};
}

std::vector<std::pair<std::string, std::size_t>> covered_by_region(const HeatScene& scene, const HeatReport& report) {
  std::vector<std::size_t> count(scene.input.regions.size(), 0);
  for (const std::uint32_t facet : report.covered) ++count[scene.input.region_of[facet]];
  std::vector<std::pair<std::string, std::size_t>> named;
  for (std::size_t r = 0; r < count.size(); ++r)
    if (count[r] > 0) named.emplace_back(scene.input.regions[r].name, count[r]);
  return named;
}

std::string HeatFiles::facets_csv() const {
  std::string text = "facet,mesh,region,material,area_m2,centre_x_m,centre_y_m,centre_z_m,normal_x,normal_y,normal_z\n";
  const auto& facets = scene_.facets().facet;
  for (std::uint32_t f = 0; f < facets.size(); ++f) {
    const Region& region = scene_.region_of(f);
    text += std::to_string(f) + "," + csv_field(file_.meshes[facets[f].mesh].name) + "," + csv_field(region.name) +
            "," + (region.material ? csv_field(file_.materials[*region.material].name) : "") + "," +
            significant(facets[f].area_m2, 9);
    for (const double value : facets[f].centre) text += "," + significant(value, 9);
    for (const double value : facets[f].normal) text += "," + significant(value, 9);
    text += "\n";
  }
  return text;
}

void HeatFiles::write(const HeatReport& report, const HeatOptions& options) {
  std::string times = "output,time,time_s\n", regions = "time,region,min_K,mean_K,max_K\n";
  for (std::size_t i = 0; i < times_s_.size(); ++i) {
    const std::string when = instant(times_s_[i]);
    times += std::to_string(i) + "," + when + "," + csv_number(times_s_[i]) + "\n";
    for (std::size_t r = 0; r < regions_[i].size(); ++r) {
      const RegionTemperature& region = regions_[i][r];
      regions += when + "," + csv_field(file_.regions[r].name);
      for (const double kelvin : {region.least_k, region.mean_k, region.most_k})
        regions += "," + (std::isnan(kelvin) ? std::string() : fixed(kelvin, 4));
      regions += "\n";
    }
  }
  front_->commit();
  if (back_) back_->commit();
  emit(at("facets.csv"), facets_csv());
  emit(at("times.csv"), times);
  emit(at("regions.csv"), regions);
  emit(at("heat.json"), heat_json(file_, scene_, report, options));
}

Fingerprints fingerprints_of(const SceneFile& file, const HeatScene& scene, const HeatOptions& options) {
  const Surroundings& s = scene.surroundings;
  const radiometry::scene::Facets& facets = scene.facets();
  std::string emissivities;
  for (const Material& material : scene.material)
    emissivities += hash_of(material.emissivity(false), material.emissivity(true));
  return {
      {"the scene file", file.sha256},
      {"a mesh", hash_of(facets.vertices, facets.triangles, facets.facet_of, scene.input.region_of, scene.opposite)},
      {"the weather",
       hash_of(s.time_s, s.air_k, s.wind_m_s, s.vapour_pa, s.direct_w_m2, s.diffuse_w_m2, s.sky_longwave_w_m2)},
      {"a spectrum of emissivity", mtf::io::sha256_hex(emissivities)},
      {"a table of temperatures or fluxes", hash_of_tables(scene.input)},
      {"an option (--tolerance, --rays, --sun-directions, --sun-points, --every-facet or --seen)",
       hash_of(options.tolerance_k, options.directions, options.rays, options.sun_points, options.patches,
               options.every_facet, options.seen)},
      {"the program", std::string(mtf::version) + " " + std::string(mtf::git_commit)}};
}

std::string unfinished_path(const std::string& folder) { return folder + "/unfinished.bin"; }

bool is_unfinished(const std::string& folder) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(unfinished_path(folder), ignored)) return false;
  std::ifstream file(unfinished_path(folder), std::ios::binary);
  std::string start(kMagic.size(), '\0');
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  return file && start == kMagic;
}

std::vector<std::string> unfinished_files(const std::string& folder) {
  return {unfinished_path(folder), folder + "/unfinished.npy", folder + "/unfinished_back.npy"};
}

void remove_unfinished(const std::string& folder) {
  for (const std::string& file : unfinished_files(folder)) std::filesystem::remove(file);
}

// A line that says what it is, the hash of all that follows, a line of JSON, the checkpoint.
void write_unfinished(const std::string& folder, const UnfinishedRun& run) {
  Json fingerprints = Json::array(), regions = Json::array();
  for (const auto& [what, print] : run.fingerprints) fingerprints.push_back({what, print});
  for (const auto& output : run.outputs.regions)
    for (const RegionTemperature& region : output) regions.push_back({region.least_k, region.mean_k, region.most_k});
  const Json head = {{"fingerprints", fingerprints}, {"times_s", run.outputs.times_s}, {"regions", regions}};
  const std::string all = json_document(head, -1) + bytes_of(run.checkpoint);
  mtf::io::write_text_file(unfinished_path(folder), std::string(kMagic) + mtf::io::sha256_hex(all) + all);
}

UnfinishedRun read_unfinished(const std::string& folder, const Fingerprints& now, std::size_t regions) {
  std::ifstream file(unfinished_path(folder), std::ios::binary);
  const std::string read{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  constexpr std::size_t kHash = 64, kBegin = kMagic.size() + kHash;
  const std::string_view bytes = std::string_view(read).substr(std::min(kBegin, read.size()));
  const std::size_t end = bytes.find('\n');
  if (end == std::string::npos || mtf::io::sha256_hex(bytes) != read.substr(kMagic.size(), kHash))
    refuse(folder, "but its unfinished.bin is damaged");
  UnfinishedRun run;
  std::size_t outputs = 0;
  try {
    const Json head = parse_json(bytes.substr(0, end));
    for (const Json& one : head.at("fingerprints").elements())
      run.fingerprints.emplace_back(one[0].get<std::string>(), one[1].get<std::string>());
    for (const Json& time : head.at("times_s").elements()) run.outputs.times_s.push_back(time.get<double>());
    outputs = run.outputs.times_s.size();
    if (outputs == 0 || head.at("regions").size() != outputs * regions) throw mtf::UsageError("regions");
    for (std::size_t i = 0; i < outputs; ++i) {
      run.outputs.regions.emplace_back();
      for (std::size_t r = 0; r < regions; ++r) {
        const Json& one = head.at("regions")[i * regions + r];
        run.outputs.regions.back().push_back({kelvin_of(one[0]), kelvin_of(one[1]), kelvin_of(one[2])});
      }
    }
  } catch (const mtf::UsageError&) {
    refuse(folder, "but its unfinished.bin is damaged");
  }
  for (std::size_t i = 0; i < now.size(); ++i)
    if (i >= run.fingerprints.size() || run.fingerprints[i] != now[i])
      refuse(folder, "and " + now[i].first + " is not what it was then");
  try {
    run.checkpoint = checkpoint_of(bytes.substr(end + 1));
    if (run.checkpoint.outputs != outputs) throw mtf::RuntimeError("outputs");
  } catch (const mtf::RuntimeError&) {
    refuse(folder, "but its unfinished.bin is damaged");
  }
  return run;
}

}  // namespace apps::scene
