// SPDX-License-Identifier: Apache-2.0

// `mtf heat`: a scene file to a folder of temperatures.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/figures/picture.h"
#include "apps/figures/plot.h"
#include "apps/options.h"
#include "apps/scene/command/heat_files.h"
#include "apps/scene/heat/read_thermal_scene.h"
#include "apps/scene/outputs/mesh_files.h"
#include "apps/scene/render/sensor_picture.h"
#include "apps/simulate/output_files.h"
#include "apps/terminal/interrupt.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "apps/terminal/progress_line.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/image.h"
#include "radiometry/weather/instant.h"

namespace apps {
namespace {

namespace fs = std::filesystem;
namespace geometry = radiometry::scene;
namespace heat = radiometry::heat;
using namespace scene;

// A picture of facets in false colours, seen by the camera of the scene, for the eye.

constexpr std::int64_t kWidth = 1280, kHeight = 960;
constexpr double kHalfWidth = 0.364;  // tan 20 deg

/// What the pixels of a picture of 1280 x 960, 40 degrees wide, show; empty when none of them shows a facet. Throws
/// UsageError for a camera whose view is not defined.
std::vector<geometry::Hit> camera_hits(const HeatScene& scene, const SceneFile& file) {
  constexpr double kPitch_um = 2e3 * kHalfWidth / kWidth;  // behind 1 mm of focal length
  const radiometry::render::Camera camera =
      radiometry::render::camera_of({1.0, kPitch_um, kPitch_um, kWidth, kHeight, 1.0}, pose_of(file));
  std::vector<geometry::Ray> rays;
  for (std::int64_t y = 0; y < kHeight; ++y)
    for (std::int64_t x = 0; x < kWidth; ++x)
      rays.push_back({camera.position, camera.direction(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5)});
  std::vector<geometry::Hit> hits(rays.size());
  scene.rays.first_hits(rays, hits);
  if (std::ranges::none_of(hits, geometry::hits)) return {};
  return hits;
}

/// The name of a mesh whose closed shells the camera sees from inside in most of its pixels.
std::optional<std::string> mesh_around_camera(const HeatScene& scene, std::span<const geometry::Hit> hits) {
  const geometry::Facets& facets = scene.facets();
  std::vector<std::size_t> inside(facets.report.size(), 0);
  for (const geometry::Hit& hit : hits)
    if (geometry::hits(hit) && hit.back && facets.shells[facets.facet[hit.facet].shell].closed)
      ++inside[facets.facet[hit.facet].mesh];
  const auto most = std::max_element(inside.begin(), inside.end());
  if (most == inside.end() || 2 * *most <= hits.size()) return std::nullopt;
  return facets.report[static_cast<std::size_t>(most - inside.begin())].name;
}

/// Writes a PNG of these pixels with a bar of temperatures. What the camera does not see, and the sky, is black.
void write_scene_picture(const std::string& path, std::span<const geometry::Hit> hits, std::span<const double> facet_k,
                         const std::string& caption) {
  std::vector<float> seen;
  for (const geometry::Hit& hit : hits)
    if (geometry::hits(hit)) seen.push_back(static_cast<float>(facet_k[hit.facet]));
  // A hundredth of the pixels may be clipped at each end: single hot facets would take all of the colours.
  std::sort(seen.begin(), seen.end());
  const double low = seen[seen.size() / 100], high = seen[seen.size() - 1 - seen.size() / 100];
  mtf::Image image(kWidth, kHeight);
  for (std::int64_t y = 0; y < kHeight; ++y)
    for (std::int64_t x = 0; x < kWidth; ++x) {
      const geometry::Hit& hit = hits[static_cast<std::size_t>(y * kWidth + x)];
      image.at(x, y) = geometry::hits(hit) ? static_cast<float>(facet_k[hit.facet]) : static_cast<float>(low);
    }
  write_picture(path, std::array{Panel{caption, image.view(), 1, low, std::max(high, low + 0.1), ""}}, true);
}

// What the temperatures depend on: the whole run again, with one thing changed at a time. Formulas of convection and
// sky and the numbers of materials are known to 10 % and less well, which is kelvins; a tolerance says nothing about
// that.

/// Temperatures of regions, [output][region], as a run has them.
using RegionOutputs = std::vector<std::vector<RegionTemperature>>;

/// How a change moves the mean temperature of a region.
struct RegionChange {
  double mean_k = 0.0;     ///< over the outputs
  double largest_k = 0.0;  ///< at the output where it is largest, with its sign
};

struct Sensitivity {
  std::string change;                 ///< "convection +10 %"
  std::vector<RegionChange> regions;  ///< as ThermalScene::regions
};

constexpr double kMore = 1.1;       ///< + 10 %
constexpr double kSky_w_m2 = 10.0;  ///< of long wave
constexpr double kFinish = 0.02;    ///< of absorptance and emissivity
constexpr double kMcAdamsStill = 5.7, kMcAdamsWind = 3.8;

heat::Convection stronger(const heat::Convection& convection) {
  if (std::holds_alternative<heat::McAdams>(convection))
    return heat::LinearConvection{kMore * kMcAdamsStill, kMore * kMcAdamsWind};
  heat::Convection more = convection;
  if (auto* linear = std::get_if<heat::LinearConvection>(&more)) {
    linear->h0_w_m2_k *= kMore;
    linear->h1_j_m3_k *= kMore;
  }
  if (auto* tarp = std::get_if<heat::Tarp>(&more)) tarp->roughness *= kMore;
  return more;
}

struct Change {
  std::string name;
  std::function<void(Material&)> of_material;
  double sky_w_m2 = 0.0;
};

std::vector<Change> changes() {
  const auto both = [](double value, double step) { return std::clamp(value + step, 0.0, 1.0); };
  return {{"convection +10 %",
           [](Material& s) {
             s.construction.convection = stronger(s.construction.convection);
             if (auto* sheet = std::get_if<heat::Sheet>(&s.construction.inside))
               sheet->convection = stronger(sheet->convection);
           }},
          {"long wave of the sky +10 W/m2", {}, kSky_w_m2},
          {"solar absorptance +0.02",
           [both](Material& s) {
             s.solar_absorptance = both(s.solar_absorptance, kFinish);
             s.back_solar_absorptance = both(s.back_solar_absorptance, kFinish);
           }},
          {"emissivity -0.02",
           [both](Material& s) {
             s.construction.emissivity = both(s.construction.emissivity, -kFinish);
             if (auto* sheet = std::get_if<heat::Sheet>(&s.construction.inside))
               sheet->emissivity = both(sheet->emissivity, -kFinish);
           }},
          {"conductivity +10 %",
           [](Material& s) {
             for (heat::Layer& layer : s.construction.layers) layer.conductivity_w_m_k *= kMore;
           }},
          {"heat capacity +10 %", [](Material& s) {
             for (heat::Layer& layer : s.construction.layers) layer.heat_capacity_j_kg_k *= kMore;
           }}};
}

std::vector<RegionChange> difference(const RegionOutputs& changed, const RegionOutputs& base) {
  std::vector<RegionChange> regions(base.front().size());
  for (std::size_t i = 0; i < base.size(); ++i)
    for (std::size_t r = 0; r < regions.size(); ++r) {
      const double kelvin = changed[i][r].mean_k - base[i][r].mean_k;
      regions[r].mean_k += kelvin / static_cast<double>(base.size());
      if (!(std::abs(kelvin) <= std::abs(regions[r].largest_k))) regions[r].largest_k = kelvin;
    }
  return regions;
}

std::string signed_text(double kelvin) {
  return std::isnan(kelvin) ? "not seen" : (kelvin < 0.0 ? "" : "+") + fixed(kelvin, 2);
}

/// Six runs: convection, long wave of the sky, solar absorptance, emissivity, conductivity, heat capacity. `base`: of
/// the scene as it is. Changes below the promise of a run are rounding of its classes, steps and cells. Of tarp only
/// the part of the wind is changed.
std::vector<Sensitivity> sensitivities(HeatScene& scene, const HeatOptions& options, const RegionOutputs& base,
                                       const std::function<void(const std::string&, double)>& progress) {
  std::vector<Sensitivity> all;
  for (const Change& change : changes()) {
    progress(change.name, static_cast<double>(all.size()) / 6.0);
    const std::vector<Material> materials = scene.material;
    const std::vector<double> sky = scene.surroundings.sky_longwave_w_m2;
    if (change.of_material)
      for (Material& material : scene.material) change.of_material(material);
    for (double& longwave : scene.surroundings.sky_longwave_w_m2) longwave += change.sky_w_m2;
    RegionOutputs regions;
    run_heat(
        scene, options,
        [&](const HeatOutput& output) { regions.push_back(region_temperatures(scene, output.front_k)); },
        [](const std::string&, double) {});
    scene.material = materials;
    scene.surroundings.sky_longwave_w_m2 = sky;
    if (regions.size() < base.size()) break;  // interrupted
    all.push_back({change.name, difference(regions, base)});
  }
  return all;
}

std::string sensitivity_table(const HeatScene& scene, const std::vector<Sensitivity>& all) {
  std::vector<std::string> header{"change of the mean [K], largest in brackets"};
  std::vector<Align> align{Align::left};
  for (const Region& region : scene.input.regions) {
    header.push_back(one_line(region.name));
    align.push_back(Align::right);
  }
  TextTable table(std::move(header));
  for (const Sensitivity& one : all) {
    std::vector<std::string> row{one.change};
    for (const RegionChange& region : one.regions)
      row.push_back(signed_text(region.mean_k) + " (" + signed_text(region.largest_k) + ")");
    table.add(std::move(row));
  }
  return table.aligned(align);
}

/// change,region,mean_K,largest_K
std::string sensitivity_csv(const HeatScene& scene, const std::vector<Sensitivity>& all) {
  std::string text = "change,region,mean_K,largest_K\n";
  for (const Sensitivity& one : all)
    for (std::size_t r = 0; r < one.regions.size(); ++r)
      text += csv_field(one.change) + "," + csv_field(scene.input.regions[r].name) + "," +
              csv_number(one.regions[r].mean_k) + "," + csv_number(one.regions[r].largest_k) + "\n";
  return text;
}

Figure region_figure(const SceneFile& file, const HeatFiles& files) {
  Figure figure;
  figure.title = "mean temperatures of regions";
  figure.x_label = "hours since " + heat::instant_text(file.time.start_s);
  figure.y_label = "temperature [K]";
  for (std::size_t r = 0; r < file.regions.size(); ++r) {
    Series series;
    series.name = file.regions[r].name;
    for (std::size_t i = 0; i < files.times_s().size(); ++i) {
      series.x.push_back(files.times_s()[i] / 3600.0);
      series.y.push_back(files.regions()[i][r].mean_k);
    }
    figure.series.push_back(std::move(series));
  }
  return figure;
}

/// The facets as a mesh of triangles, with their temperatures.
void write_mesh_of(const std::string& path, const HeatScene& scene, std::span<const double> facet_k, bool vtk) {
  const geometry::Facets& facets = scene.facets();
  geometry::Mesh mesh;
  mesh.vertices = facets.vertices;
  mesh.group_names = mesh.material_names = {""};
  mesh.first.push_back(0);
  std::vector<float> of_face;
  std::vector<double> sum(facets.vertices.size(), 0.0), area(facets.vertices.size(), 0.0);
  for (std::size_t t = 0; t < facets.triangles.size(); ++t) {
    const std::uint32_t facet = facets.facet_of[t];
    for (const std::uint32_t corner : facets.triangles[t]) {
      if (std::isnan(facet_k[facet])) continue;  // not asked for
      sum[corner] += facets.facet[facet].area_m2 * facet_k[facet];
      area[corner] += facets.facet[facet].area_m2;
    }
    mesh.add_face(facets.triangles[t]);
    of_face.push_back(static_cast<float>(facet_k[facet]));
  }
  std::vector<float> of_vertex;
  for (std::size_t v = 0; v < sum.size(); ++v)
    of_vertex.push_back(area[v] > 0.0 ? static_cast<float>(sum[v] / area[v]) : std::nanf(""));
  const auto write = vtk ? write_vtk : write_ply;
  write(path, mesh, {{"temperature", of_vertex}}, {{"temperature", of_face}});
}

std::string covered_text(const HeatScene& scene, const HeatReport& report) {
  const auto said = [](const auto& region) { return one_line(region.first) + " " + std::to_string(region.second); };
  return "facets inside other solids, without sun and sky: " + joined(covered_by_region(scene, report), said) + "\n";
}

std::string left_out_text(const HeatReport& report) {
  const LeftOut& out = *report.left_out;
  return "the camera sees " + std::to_string(report.facets - out.facets) + " facets, of which regions are the means; " +
         std::to_string(out.units) + " classes that it does not see are left out, which changes the others by " +
         significant(out.error_k.rms, 2) + " K rms, " + significant(out.error_k.percentile_95, 2) +
         " K for 95 %, at most " + significant(out.largest_k, 2) + " K (standard errors)\n";
}

std::string error_text(const RealisedError& error) {
  return significant(error.rms_k, 2) + " K rms, below " + significant(error.percentile_95_k, 2) + " K in 95 % and " +
         significant(error.percentile_999_k, 2) + " K in 99.9 % of the facets, at most " +
         significant(error.largest_k, 2) + " K\n";
}

std::string verification_text(const Verification& verified, bool with_left_out) {
  return std::string("realised, ") + (with_left_out ? "with what is left out, " : "") + "against runs that promise " +
         significant(verified.as_units.promised_k, 2) + " K:\n  classes as they are " + error_text(verified.as_units) +
         "  each facet by itself, with shadows of its own " + error_text(verified.by_itself);
}

std::string summary_text(const HeatScene& scene, const HeatReport& report, const HeatFiles& files) {
  TextTable table({"region", "coldest", "mean", "warmest [K]"});
  for (std::size_t r = 0; r < scene.input.regions.size(); ++r) {
    double least = files.regions().front()[r].least_k, most = files.regions().front()[r].most_k, mean = 0.0;
    for (const auto& regions : files.regions()) {
      least = std::min(least, regions[r].least_k);
      most = std::max(most, regions[r].most_k);
      mean += regions[r].mean_k / static_cast<double>(files.regions().size());
    }
    const auto cell = [](double kelvin) { return std::isnan(kelvin) ? std::string("not seen") : fixed(kelvin, 2); };
    table.add({one_line(scene.input.regions[r].name), cell(least), cell(mean), cell(most)});
  }
  const HeatPromise& p = report.promised;
  std::string text = table.aligned({Align::left, Align::right, Align::right, Align::right});
  text += plural(static_cast<std::int64_t>(report.facets), "facet") + " as " + std::to_string(report.units) +
          (report.units == 1 ? " class, " : " classes, ") +
          plural(static_cast<std::int64_t>(report.outputs), "output") + "\n";
  if (!report.covered.empty()) text += covered_text(scene, report);
  text += "promised error " + significant(p.total_k(), 2) + " K: " + significant(p.feedback, 3) + " (exchange) x (" +
          significant(p.solver.total_k(), 2) + " steps, cells and start + " + significant(p.ground_k, 2) +
          " ground + " + significant(p.units_k, 2) + " classes + " + significant(p.exchange_k, 2) +
          " iteration of the exchange" + ")\n";
  const ViewSpread& spread = report.view_spread;
  text += "measured, not in it: views of facets against those of their class " + significant(spread.error_k.rms, 2) +
          " K rms, " + significant(spread.error_k.percentile_95, 2) + " K for 95 %, at most " +
          significant(spread.largest_k, 2) + " K; shadows " +
          significant(100.0 * report.sun_error.of_directions.rms, 2) +
          " % of the direct light rms, at all times below " +
          significant(100.0 * report.sun_error.of_sides.percentile_95, 2) + " % in 95 % of the facets\n";
  if (report.left_out) text += left_out_text(report);
  text += "models of convection and sky: 1 to 3 K\n";
  if (report.verified) text += verification_text(*report.verified, report.left_out.has_value());
  double total = 0.0;
  std::string times;
  for (const auto& [name, ms] : report.timing_ms) {
    times += (times.empty() ? "" : ", ") + name + " " + fixed(ms / 1000.0, 2);
    total += ms;
  }
  return text + "time " + fixed(total / 1000.0, 2) + " s (" + times + ")\n";
}

/// The results so far of a run that was interrupted.
bool holds_part(const std::string& folder) {
  std::ifstream file(folder + "/heat.json");
  const std::optional<Json> json = parsed_json(std::string{std::istreambuf_iterator<char>(file), {}});
  if (!json || !json->contains("closures")) return false;
  const Json* finished = json->find("finished");
  return finished && finished->is_boolean() && !finished->get<bool>();
}

}  // namespace

int run_heat(const HeatCommandOptions& options, const Global& global) {
  // An interrupted run is continued, or replaced, without --force.
  const bool part = holds_part(options.out),
             resumable = is_unfinished(options.out) || (part && fs::exists(unfinished_path(options.out))),
             unfinished = resumable || part, force = options.force || unfinished;
  if (options.anew && !unfinished && !options.force)
    throw mtf::UsageError("--anew: " + one_line(options.out) + " holds no interrupted run");
  std::vector<mtf::io::Diagnostic> findings;
  const SceneFile file = load_scene(options.scene, &findings);
  for (const std::string& name : unfinished_files(options.out))
    for (const std::string& input : files_of(file)) require_different(input, name);
  OutputSet outputs({.folder = options.out, .force = force, .names = heat_names(), .inputs = files_of(file)});
  for (const mtf::io::Diagnostic& finding : findings) note(global, mtf::io::format_diagnostic(finding, file.file));
  StopInGoodOrder interrupt(
      "mtf: interrupted: the day that is being solved is finished and written first; once more to stop at once\n");
  HeatOptions heat_options{.tolerance_k = options.tolerance_k.value_or(0.1),
                           .directions = options.directions,
                           .rays = options.rays,
                           .sun_points = options.sun_points,
                           .every_facet = options.every_facet,
                           .seen = options.seen,
                           .verify = options.verify,
                           .threads = global.threads,
                           .go_on = [&] { return !interrupt.asked(); },
                           .keep_every_s = options.save_every_s};
  ProgressLine progress(global);
  HeatScene scene = prepare_heat(file, heat_options);
  for (const std::string& warning : scene.warnings) note(global, "warning: " + warning);
  std::optional<UnfinishedRun> earlier;
  if (resumable && !options.anew) {
    if (options.verify || options.sensitivity)
      throw mtf::UsageError(
          one_line(options.out) +
          " holds a run that was interrupted, and --verify and --sensitivity need one from its begin: "
          "--anew begins again, without them it goes on");
    earlier = read_unfinished(options.out, fingerprints_of(file, scene, heat_options), file.regions.size());
    heat_options.from = &earlier->checkpoint;
    note(global, "note: going on after " + std::to_string(earlier->checkpoint.outputs) + " outputs, at " +
                     heat::instant_text(file.time.start_s + earlier->outputs.times_s.back()));
  }
  std::vector<geometry::Hit> seen;
  if (file.camera) seen = camera_hits(scene, file);
  if (options.seen)
    for (const geometry::Hit& hit : seen)
      if (hits(hit)) scene.seen[hit.facet] = true;
  if (file.camera && seen.empty())
    note(global, "warning: [camera] sees nothing of the scene, so there is no picture of it");
  if (const auto mesh = mesh_around_camera(scene, seen))
    note(global, "warning: [camera] stands inside of a closed mesh, '" + one_line(*mesh) +
                     "': the picture shows the inner sides of its faces");
  std::string sensitivity;
  double until_s = 0.0;
  HeatFiles files(outputs.in(""), options.out, file, scene);
  if (earlier) files.take_over(earlier->outputs);
  auto write_state = [&, fingerprints = Fingerprints()](const Checkpoint& state) mutable {
    if (fingerprints.empty()) fingerprints = fingerprints_of(file, scene, heat_options);
    write_unfinished(options.out, {fingerprints, {files.times_s(), files.regions()}, state});
  };
  heat_options.keep = [&](const Checkpoint& state) {
    if (files.keep()) write_state(state);
  };
  std::vector<double> last;
  const HeatReport report = run_heat(
      scene, heat_options,
      [&](const HeatOutput& output) {
        files.append(output);
        last.assign(output.front_k.begin(), output.front_k.end());
        until_s = output.time_s;
        interrupt.keep();
      },
      [&](const std::string& step, double share) { progress.update(step, share); });
  for (std::size_t i = scene.warnings.size(); i < report.warnings.size(); ++i)
    note(global, "warning: " + report.warnings[i]);
  const double promised_k = report.promised.total_k(), spread_k = report.view_spread.error_k.percentile_95;
  const std::optional<Verification>& verified = report.verified;
  if (report.checkpoint) {
    files.keep();
    write_state(*report.checkpoint);
  }
  files.write(report, heat_options);
  outputs.commit();  // what was solved for, before the pictures of it
  if (!report.checkpoint) remove_unfinished(options.out);
  write_figure(outputs.in("regions.svg"), region_figure(file, files));
  if (!seen.empty())
    write_scene_picture(outputs.in("scene.png"), seen, last,
                        "surface temperatures [K] at " + heat::instant_text(file.time.start_s + until_s));
  if (options.ply) write_mesh_of(outputs.in("facets.ply"), scene, last, false);
  if (options.vtk) write_mesh_of(outputs.in("facets.vtk"), scene, last, true);
  if (options.sensitivity && until_s + 0.01 >= file.time.end_s - file.time.start_s) {
    heat_options.keep = {};
    const std::vector<Sensitivity> all =
        sensitivities(scene, heat_options, files.regions(),
                      [&](const std::string& step, double share) { progress.update("sensitivity: " + step, share); });
    emit(outputs.in("sensitivity.csv"), sensitivity_csv(scene, all));
    sensitivity = "\n" + sensitivity_table(scene, all);
  }
  outputs.commit();
  print(options.format == Format::json ? heat_json(file, scene, report, heat_options)
                                       : summary_text(scene, report, files) + sensitivity);
  if (spread_k > heat_options.tolerance_k)
    note(global, "warning: what facets see differs from what their class sees by up to " + significant(spread_k, 2) +
                     " K (95 % of them), more than the tolerance; more --rays, or --every-facet, bring it down");
  if (options.format == Format::table) print("written to " + options.out + "/\n");
  if (until_s + 0.01 < file.time.end_s - file.time.start_s) {
    complain("mtf: interrupted: the temperatures end at " + heat::instant_text(file.time.start_s + until_s) +
             "; the same command goes on from there");
    return 130;
  }
  // What is left out is no part of the promise: its standard error is stated beside it.
  constexpr double kStandardErrors = 4.0;
  const double left_out_k = report.left_out ? report.left_out->largest_k : 0.0;
  if (verified &&
      verified->as_units.largest_k - verified->as_units.promised_k > promised_k + kStandardErrors * left_out_k) {
    complain("mtf: PROMISE BROKEN: promised " + significant(promised_k, 3) + " K, realised " +
             significant(verified->as_units.largest_k, 3) + " K in facet " + std::to_string(verified->as_units.facet));
    return 3;
  }
  if (verified && verified->by_itself.percentile_95_k > heat_options.tolerance_k)
    note(global, "warning: by itself and with shadows of its own, one facet in twenty is off by more than " +
                     significant(verified->by_itself.percentile_95_k, 2) +
                     " K, above the tolerance; --sun-directions, --sun-points and --every-facet bring it down");
  if (options.verify && !verified) note(global, "note: interrupted: the realised error is not known");
  if (promised_k <= heat_options.tolerance_k) return 0;
  complain("mtf: warning: the promised error of " + significant(promised_k, 3) + " K is above the tolerance of " +
           significant(heat_options.tolerance_k, 3) + " K");
  return 3;
}

}  // namespace apps
