// SPDX-License-Identifier: Apache-2.0
#include "apps/study/design/metric_list.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <vector>

#include "apps/sensor/sensor_air.h"
#include "apps/study/design/metric_rows.h"
#include "apps/study/design/variant_sensor.h"
#include "apps/study/study_shape.h"
#include "mtf/error.h"
#include "mtf/field/image_places.h"
#include "mtf/otf/otf_parts.h"
#include "mtf/units.h"

namespace study {
namespace {

constexpr std::string_view kOtf = "Boreman, Modulation Transfer Function in Optical and Electro-Optical Systems, 2001";
constexpr std::string_view kFiete = "Fiete, Modeling the Imaging Chain of Digital Cameras, 2010";
constexpr std::string_view kGiqe4 = "Leachtenauer et al., Appl. Opt. 36, 8322 (1997)";
constexpr std::string_view kSampled =
    "Driggers et al., Introduction to Infrared and Electro-Optical Systems, 2nd ed., 2012";
constexpr std::string_view kMeasure = "as mtf measure (ISO 12233 terms)";
constexpr std::string_view kOptics = "Born and Wolf, Principles of Optics, ch. 9";
constexpr std::string_view kCamera = "camera equation: LeMaster and Eismann, Proc. SPIE 10204, 1020405 (2017)";
constexpr std::string_view kNetd = "Lloyd, Thermal Imaging Systems, ch. 5";
constexpr std::string_view kNvl = "AMSEL-NV-TR-230 (2004), NVThermIP form: E = 1.51 + 0.24 V/V50";
constexpr std::string_view kMrtd = "FLIR92: Scott and D'Agostino, Proc. SPIE 1689, 55 (1992)";
constexpr std::string_view kMdtd = "Lloyd, Thermal Imaging Systems, ch. 5, with the noise of FLIR92";
constexpr std::string_view kJohnson =
    "Johnson 1958 with the 2-D MRTD; N50 0.75, 3, 6: Kennedy 1991, doi 10.1117/12.45802";

constexpr std::string_view kRange = "[conditions] range";
constexpr std::string_view kContrast = "[detector] and [conditions] contrast or signal_contrast";
constexpr std::string_view kQuality = "[detector], [conditions] range, and contrast or signal_contrast";
constexpr std::string_view kTarget = "[detector], [conditions] contrast and target_size";
constexpr std::string_view kObserver =
    "[detector], [conditions] contrast, and magnification or display_height with viewing_distance";
constexpr std::string_view kObservedTarget =
    "[detector], [conditions] contrast and target_size, and magnification or display_height with viewing_distance";

using enum Metric;
constexpr std::array kRows{
    MetricRow{cutoff, "cutoff", false, "cy/mm", "lowest frequency from which on the optics pass nothing", kOtf,
              "a pupil: diffraction, defocus or wavefront", Effort::points},
    MetricRow{nyquist, "nyquist", true, "cy/mm", "1 / (2 pitch)", kOtf, "", Effort::geometry},
    MetricRow{q, "q", true, "", "sampling frequency / optical cutoff = lambda N / pitch", kFiete,
              "a pupil: diffraction, defocus or wavefront", Effort::points},
    MetricRow{ifov, "ifov", true, "urad", "pitch / focal length", kOtf, "", Effort::geometry},
    MetricRow{gsd, "gsd", true, "m", "range x pitch / focal length, in the plane of the image", kFiete, kRange,
              Effort::geometry},
    MetricRow{fov, "fov", true, "deg", "2 atan(pixels x pitch / (2 focal length))", kOtf, "[frame] format",
              Effort::geometry},
    MetricRow{optics_mtf_nyquist, "optics_mtf_nyquist", true, "", "MTF of the optics at Nyquist", kOtf, "",
              Effort::points},
    MetricRow{detector_mtf_nyquist, "detector_mtf_nyquist", true, "",
              "MTF of the detector (footprint, diffusion ...) at Nyquist", kOtf, "", Effort::points},
    MetricRow{presample_mtf_nyquist, "presample_mtf_nyquist", true, "",
              "MTF of all that lies before sampling at Nyquist", kOtf, "", Effort::points},
    MetricRow{mtf_nyquist, "mtf_nyquist", true, "", "MTF of the whole system at Nyquist", kOtf, "", Effort::points},
    MetricRow{folded_mtf_nyquist, "folded_mtf_nyquist", true, "",
              "2 x sum of the presample MTF at odd multiples of Nyquist: with its replicas in phase", kSampled, "",
              Effort::points},
    MetricRow{mtf50, "mtf50", true, "cy/px", "lowest frequency at which the system MTF is 0.5", kMeasure, "",
              Effort::mtf50},
    MetricRow{mtfa, "mtfa", true, "", "mean of the system MTF from 0 to Nyquist", kMeasure, "", Effort::area},
    MetricRow{rer, "rer", true, "", "relative edge response: rise of the edge from -0.5 to +0.5 px", kFiete, "",
              Effort::edge},
    MetricRow{edge_overshoot, "edge_overshoot", true, "", "largest value of the edge from 1 to 3 px beyond it, less 1",
              kMeasure, "", Effort::overshoot, true},
    MetricRow{edge_height, "edge_height", true, "",
              "GIQE's H: the edge at 1.25 px where it rises up to 3 px, else its largest value from 1 to 3 px", kGiqe4,
              "", Effort::overshoot, true},
    MetricRow{fwhm, "fwhm", true, "px", "full width of the line spread at half of its peak", kOtf, "", Effort::fwhm,
              true},
    MetricRow{aliasing_ratio, "aliasing_ratio", true, "",
              "integral of the presample MTF beyond Nyquist / integral up to it", kSampled, "", Effort::aliasing, true},
    MetricRow{spurious_in_band, "spurious_in_band", true, "",
              "replicas below Nyquist, filtered by what follows sampling / base band", kSampled, "", Effort::aliasing,
              true},
    MetricRow{spurious_out_of_band, "spurious_out_of_band", true, "",
              "replicas beyond Nyquist, filtered by the display / base band", kSampled,
              "a display, interpolation or eye in [[postsample]]", Effort::spurious, true},
    MetricRow{spurious_response, "spurious_response", true, "", "spurious_in_band + spurious_out_of_band", kSampled,
              "a display, interpolation or eye in [[postsample]]", Effort::spurious, true},
    MetricRow{strehl, "strehl", false, "",
              "optics' point spread at the image of the axis / the peak of the same pupil without aberration", kOptics,
              "a pupil: diffraction, defocus or wavefront", Effort::light},
    MetricRow{ensquared_energy, "ensquared_energy", false, "",
              "share of the optics' point spread in one pitch about the image of the axis", kOptics,
              "a pupil: diffraction, defocus or wavefront", Effort::light},
    MetricRow{signal, "signal", false, "e-", "electrons of the scene, the row scene of mtf budget", kCamera,
              "[detector]", Effort::budget},
    MetricRow{background, "background", false, "e-", "electrons of path, optics, stop and dark current", kCamera,
              "[detector]", Effort::budget},
    MetricRow{well_fill, "well_fill", false, "", "all electrons / full well", kCamera, "[detector] full_well",
              Effort::budget},
    MetricRow{scene_shot_noise, "scene_shot_noise", false, "e-", "shot noise of scene and path, rms", kNetd,
              "[detector]", Effort::budget},
    MetricRow{background_shot_noise, "background_shot_noise", false, "e-", "shot noise of optics and stop, rms", kNetd,
              "[detector]", Effort::budget},
    MetricRow{dark_shot_noise, "dark_shot_noise", false, "e-", "shot noise of the dark current, rms", kNetd,
              "[detector]", Effort::budget},
    MetricRow{read_noise, "read_noise", false, "e-", "read noise, rms", kNetd, "[detector]", Effort::budget},
    MetricRow{reset_noise, "reset_noise", false, "e-", "kTC noise, rms", kNetd, "[detector]", Effort::budget},
    MetricRow{other_noise, "other_noise", false, "e-", "further temporal noise, rms", kNetd, "[detector]",
              Effort::budget},
    MetricRow{quantisation_noise, "quantisation_noise", false, "e-", "electrons of a count / sqrt(12)", kNetd,
              "[detector] and [adc]", Effort::budget},
    MetricRow{temporal_noise, "temporal_noise", false, "e-", "root sum of squares of the temporal terms", kNetd,
              "[detector]", Effort::budget},
    MetricRow{prnu_noise, "prnu_noise", false, "e-",
              "responsivity non-uniformity x electrons of light, rms; what [correction] leaves of it where given",
              kNetd, "[detector]", Effort::budget},
    MetricRow{dsnu_noise, "dsnu_noise", false, "e-",
              "non-uniformity of offset and dark charge, rms; what [correction] leaves of it where given", kNetd,
              "[detector]", Effort::budget},
    MetricRow{correction_noise, "correction_noise", false, "e-", "noise of the flat frames of [correction], rms",
              "radiometry/performance/correction_residual.h", "[detector]", Effort::budget},
    MetricRow{spatial_noise, "spatial_noise", false, "e-", "root sum of squares of the spatial terms", kNetd,
              "[detector]", Effort::budget},
    MetricRow{snr, "snr", false, "", "electrons of the scene / temporal noise", kNetd, "[detector]", Effort::budget},
    MetricRow{netd, "netd", false, "mK", "temporal noise / (d electrons / dT)", kNetd, "[detector]", Effort::budget},
    MetricRow{shot_netd, "shot_netd", false, "mK", "the same from the shot noise of all light alone", kNetd,
              "[detector]", Effort::budget},
    MetricRow{spatial_netd, "spatial_netd", false, "mK", "the same from the spatial noise", kNetd, "[detector]",
              Effort::budget},
    MetricRow{nei, "nei", false, "s^-1 m^-2",
              "noise-equivalent irradiance, photons of the scene's spectrum at the detector", kNetd, "[detector]",
              Effort::budget},
    MetricRow{nep, "nep", false, "pW",
              "incident power at the middle of the band that equals the temporal noise of a thermal detector",
              "Kruse and Skatrud, Uncooled Infrared Imaging Arrays and Systems", "[detector] kind = \"thermal\"",
              Effort::budget},
    MetricRow{
        dynamic_range, "dynamic_range", false, "",
        "full well, or the largest count where that comes first, / noise without light; a ratio, in mtf budget dB",
        kNetd, "[detector] full_well", Effort::budget},
    MetricRow{target_snr, "target_snr", false, "",
              "electrons that the target has more than its background / temporal noise of the background", kFiete,
              kContrast, Effort::budget},
    MetricRow{niirs_giqe3, "niirs_giqe3", false, "", "NIIRS by the general image quality equation 3",
              "IBSM 4 (ERIM 253885-4-F), 3-56", kQuality, Effort::giqe},
    MetricRow{niirs_giqe4, "niirs_giqe4", false, "", "NIIRS by the general image quality equation 4", kGiqe4, kQuality,
              Effort::giqe},
    MetricRow{niirs_giqe5, "niirs_giqe5", false, "", "NIIRS by the general image quality equation 5",
              "NGA, General Image Quality Equation 5.0 (2015)", kQuality, Effort::giqe},
    MetricRow{grd, "grd", false, "m",
              "ground resolved distance: period of the finest bars that can be seen in the noise",
              "IBSM 4 (ERIM 253885-4-F), 3-54", kQuality, Effort::grd, true},
    MetricRow{mrtd, "mrtd", false, "mK", "2-D minimum resolvable temperature difference at half of Nyquist", kMrtd,
              "[detector]", Effort::bars, true},
    MetricRow{
        mdtd,
        "mdtd", false, "mK",
        "minimum detectable temperature difference of a square of 2 pixels (1 / Nyquist), the width of a bar of mrtd",
        kMdtd, "[detector]", Effort::bars, true},
    MetricRow{johnson_detect, "johnson_range_detect", false, "m",
              "range of detection with [conditions] probability, Johnson's criteria", kJohnson, kTarget, Effort::air},
    MetricRow{johnson_recognise, "johnson_range_recognise", false, "m",
              "range of recognition with [conditions] probability, Johnson's criteria", kJohnson, kTarget, Effort::air},
    MetricRow{johnson_identify, "johnson_range_identify", false, "m",
              "range of identification with [conditions] probability, Johnson's criteria", kJohnson, kTarget,
              Effort::air},
    MetricRow{ttp, "ttp", false, "cy/mrad",
              "targeting task performance of the target's contrast at range 0, up to the optical cutoff, aliasing not "
              "counted",
              kNvl, kObserver, Effort::air},
    MetricRow{ttp_detect, "ttp_range_detect", false, "m", "range of detection with [conditions] probability, TTP", kNvl,
              kObservedTarget, Effort::air},
    MetricRow{ttp_recognise, "ttp_range_recognise", false, "m",
              "range of recognition with [conditions] probability, TTP", kNvl, kObservedTarget, Effort::air},
    MetricRow{ttp_identify, "ttp_range_identify", false, "m",
              "range of identification with [conditions] probability, TTP", kNvl, kObservedTarget, Effort::air}};

constexpr MetricRow kMtfAt{mtf_at, "mtf_at", true,          "", "MTF of the whole system at a frequency",
                           kOtf,   "",       Effort::points};

/// "mtf_at_20_cy_mm": a number and one of three units.
std::optional<MetricChoice> choose_mtf_at(std::string_view name, std::optional<mtf::Axis> axis) {
  constexpr std::string_view start = "mtf_at_";
  constexpr std::array<std::pair<std::string_view, std::string_view>, 3> units{
      {{"_cy_mm", "cy/mm"}, {"_cy_mrad", "cy/mrad"}, {"_cy_px", "cy/px"}}};
  if (!name.starts_with(start)) return std::nullopt;
  for (const auto& [ending, unit] : units) {
    if (!name.ends_with(ending) || name.size() <= start.size() + ending.size()) continue;
    const std::string_view digits = name.substr(start.size(), name.size() - start.size() - ending.size());
    double value = 0.0;
    const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (status != std::errc{} || end != digits.data() + digits.size() || !(value >= 0.0 && value <= 1e9))
      return std::nullopt;
    return MetricChoice{&kMtfAt, axis, {value, mtf::find_unit(unit)}};
  }
  return std::nullopt;
}

MetricInfo info_of(const MetricRow& row, std::string name, std::optional<mtf::Axis> axis) {
  const char* along = !row.directional        ? ""
                      : !axis                 ? "; geometric mean of both axes"
                      : *axis == mtf::Axis::x ? "; along x"
                                              : "; along y";
  return {std::move(name), std::string(row.unit), std::string(row.definition) + along, std::string(row.source),
          std::string(row.needs)};
}

/// The metric of a name without the place in the image.
std::optional<MetricChoice> choose_figure(std::string_view name) {
  for (const MetricRow& row : kRows)
    if (row.name == name) return MetricChoice{&row};
  std::optional<mtf::Axis> axis;
  if (name.ends_with("_x")) axis = mtf::Axis::x;
  if (name.ends_with("_y")) axis = mtf::Axis::y;
  if (axis) name.remove_suffix(2);
  for (const MetricRow& row : kRows)
    if (axis && row.directional && row.name == name) return MetricChoice{&row, axis};
  return choose_mtf_at(name, axis);
}

/// "no [conditions] range, such as range = "5 km"": `keys` of which the first is shown as it is written.
std::string no_condition(std::string_view keys) {
  const std::string first(keys.substr(0, keys.find(' ')));
  std::string text = "no [conditions] " + std::string(keys);
  for (const mtf::FieldInfo& field : condition_fields())
    if (field.name == first) text += ", such as " + first + " = " + std::string(field.example);
  return text;
}

}  // namespace

std::span<const MetricRow> metric_rows() { return kRows; }

const MetricRow& row_of(Metric metric) {
  return *std::find_if(kRows.begin(), kRows.end(), [&](const MetricRow& row) { return row.metric == metric; });
}

std::optional<MetricChoice> choose_metric(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, Over>, 3> endings{
      {{".axis", Over::axis}, {".mean", Over::mean}, {".worst", Over::worst}}};
  for (const auto& [ending, over] : endings) {
    if (!name.ends_with(ending)) continue;
    auto choice = choose_figure(name.substr(0, name.size() - ending.size()));
    const Effort effort = choice ? choice->row->effort : Effort::geometry;
    if (effort == Effort::geometry || effort == Effort::budget || effort == Effort::air) return std::nullopt;
    choice->over = over;
    return choice;
  }
  return choose_figure(name);
}

std::span<const MetricInfo> metric_catalogue() {
  static const std::vector<MetricInfo> list = [] {
    std::vector<MetricInfo> all;
    for (const MetricRow& row : kRows) {
      all.push_back(info_of(row, std::string(row.name), {}));
      if (!row.directional) continue;
      all.push_back(info_of(row, std::string(row.name) + "_x", mtf::Axis::x));
      all.push_back(info_of(row, std::string(row.name) + "_y", mtf::Axis::y));
    }
    return all;
  }();
  return list;
}

std::optional<MetricInfo> find_metric(std::string_view name) {
  const auto choice = choose_metric(name);
  if (!choice) return std::nullopt;
  MetricInfo info = info_of(*choice->row, std::string(name), choice->axis);
  if (choice->row->metric == Metric::mtf_at)
    info.definition += ", " + mtf::format_double(choice->at.value) + " " + std::string(choice->at.unit->name);
  if (choice->over == Over::mean) info.definition += "; mean over the image";
  if (choice->over == Over::worst)
    info.definition += "; the worst of " + std::to_string(mtf::kImagePlaces * mtf::kImagePlaces) +
                       " places of the image, of more where tables are finer";
  return info;
}

std::string metric_gap(const MetricChoice& choice, const Study& study, const VariantSensor& sensor) {
  const Effort effort = choice.row->effort;
  const Metric metric = choice.row->metric;
  const Conditions& given = study.conditions;
  const bool quality = effort == Effort::giqe || effort == Effort::grd;
  const bool acquisition = effort == Effort::bars || effort == Effort::air;
  if ((effort == Effort::budget || quality || acquisition) && !sensor.no_budget.empty()) return sensor.no_budget;
  const bool own_range = sensor.loaded && apps::stated_range_m(sensor.loaded->sensor.settings);
  if ((metric == Metric::gsd || quality) && !given.range_m && !own_range) return no_condition("range");
  if ((metric == Metric::target_snr || quality) && !given.contrast_k && !given.signal_contrast)
    return no_condition("contrast or signal_contrast");
  if (is_at_a_range(*choice.row) && !sensor.no_focus.empty()) return sensor.no_focus;
  if (effort == Effort::air) {
    if (!given.contrast_k) return no_condition("contrast");
    if (metric != Metric::ttp && !given.target_size_m) return no_condition("target_size");
    const auto tasks = range_tasks(given);
    const bool bars = std::any_of(tasks.begin(), tasks.end(),
                                  [&](const RangeTask& task) { return task.metric == metric && task.by_bars; });
    if (!bars) try {
        static_cast<void>(radiometry::viewing_of(given, sensor.system.frame));
      } catch (const mtf::UsageError& missing) {
        return missing.what();
      }
    if (!sensor.no_ranges.empty()) return sensor.no_ranges;
  }
  const auto& list = sensor.system.list(mtf::Stage::presample);
  const mtf::Context<double> middle = sensor.system.context();
  if (metric == Metric::cutoff &&
      std::ranges::none_of(list, [&](const auto& e) { return e.component.cutoff_cy_mm(middle) < mtf::kInfinity; }))
    return "no pupil (diffraction, defocus or wavefront), and no curve that ends at 0";
  const bool pupil = effort == Effort::light || metric == Metric::q;
  if (pupil && std::none_of(list.begin(), list.end(), [](const auto& e) { return e.component.is_pupil(); }))
    return "no pupil: diffraction, defocus or wavefront";
  const bool over_image = choice.over != Over::axis && (!sensor.system.is_isoplanatic() || has_vignetting(sensor));
  if ((metric == Metric::fov || over_image) && (sensor.system.frame.columns <= 0 || sensor.system.frame.rows <= 0))
    return "no [frame] format; write format = [640, 512], columns and rows";
  if (effort == Effort::spurious && !mtf::is_reconstructed(sensor.system))
    return "no display, interpolation or eye in [[postsample]]";
  const bool thermal = sensor.loaded && sensor.loaded->sensor.settings.thermal;
  if (metric == Metric::nep && sensor.loaded && !thermal) return "no [detector] kind = \"thermal\"";
  const bool of_electrons = choice.row->unit == "e-" || metric == Metric::well_fill || metric == Metric::shot_netd ||
                            metric == Metric::nei || metric == Metric::dynamic_range;
  if (thermal && of_electrons) return "a thermal detector has no electrons and no photons; take netd, nep or snr";
  if (thermal && acquisition && !(given.frame_rate_hz > 0.0)) {
    const auto& frame = sensor.loaded->sensor.settings.frame;
    if (!frame || !frame->frame_time_s)
      return "no [frame] frame_time; write frame_time = \"33 ms\" there, or give [conditions] frame_rate";
  }
  if (metric == Metric::dynamic_range && sensor.loaded && sensor.loaded->sensor.settings.detector &&
      !std::isfinite(sensor.loaded->sensor.settings.detector->full_well_e))
    return "no [detector] full_well";
  return "";
}

std::string metric_gap(const MetricInfo& metric, const Study& study) {
  const auto choice = choose_metric(metric.name);
  if (!choice) return "";
  std::vector<int> levels(study.axes.size(), 0);
  const auto over_sensor = std::find_if(study.axes.begin(), study.axes.end(), [&](const Axis& axis) {
    return study.parameters[static_cast<std::size_t>(axis.parameter)].path == "sensor";
  });
  const std::size_t count = over_sensor == study.axes.end() ? 1 : over_sensor->levels.size();
  std::string gap;
  for (std::size_t level = 0; level < count; ++level) {
    if (over_sensor != study.axes.end())
      levels[static_cast<std::size_t>(over_sensor - study.axes.begin())] = static_cast<int>(level);
    const VariantSensor sensor = load_variant(study, levels);
    if (!sensor.problems.empty()) return "";  // reported elsewhere
    gap = metric_gap(*choice, study, sensor);
    if (gap.empty()) return "";
  }
  return gap;
}

}  // namespace study
