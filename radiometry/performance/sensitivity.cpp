// SPDX-License-Identifier: Apache-2.0
#include "radiometry/performance/sensitivity.h"

#include <cmath>

#include "radiometry/performance/implicit_root.h"

namespace radiometry {
namespace {

std::vector<BudgetRow> terms(const Budget<double>& b) {
  const Signal<double>& s = b.signal;
  std::vector<BudgetRow> all;
  add_rows(all, BudgetGroup::signal,
           {{"scene", "e-", s.scene_e, "electrons of the scene"},
            {"path", "e-", s.path_e, "electrons of the path between scene and camera"},
            {"optics", "e-", s.optics_e, "electrons of the warm optics"},
            {"stop", "e-", s.stop_e, "electrons from around the cone of light"},
            {"dark", "e-", s.dark_e, "electrons of the dark current"},
            {"total", "e-", s.total_e(), "all electrons"},
            {"well_fill", "", b.well_fill, "part of the full well"},
            {"signal_per_k", "e-/K", b.signal_per_k, "electrons per kelvin of the scene"}});
  add_rows(all, BudgetGroup::temporal,
           {{"scene_shot", "e-", b.scene_shot_e, "shot noise of scene and path"},
            {"background_shot", "e-", b.background_shot_e, "shot noise of optics and stop"},
            {"dark_shot", "e-", b.dark_shot_e, "shot noise of the dark current"},
            {"read", "e-", b.read_e, "read noise"},
            {"reset", "e-", b.reset_e, "kTC noise"},
            {"other", "e-", b.other_e, "further temporal noise"},
            {"quantisation", "e-", b.quantisation_e, "rounding to counts, the part that changes from frame to frame"}},
           true);
  add_rows(all, BudgetGroup::temporal,
           {{"temporal", "e-", b.temporal_e, "temporal noise, root sum of squares"},
            {"floor", "e-", b.floor_e, "temporal noise without light"}});
  add_spatial_rows(all, b, "e-", "offset and dark charge (dsnu, or its map; dcnu)");
  add_rows(all, BudgetGroup::sensitivity,
           {{"snr", "", b.snr, "scene / temporal noise"},
            {"shot_netd", "mK", 1e3 * b.shot_netd_k, "NETD from the shot noise of light alone"},
            {"netd", "mK", 1e3 * b.netd_k, "noise-equivalent temperature difference, temporal"},
            {"spatial_netd", "mK", 1e3 * b.spatial_netd_k, "the same from the spatial noise"},
            {"nei", "s^-1 m^-2", b.nei_ph, "noise-equivalent irradiance, photons of the scene's spectrum"},
            {"dynamic_range", "dB", 20.0 * std::log10(b.dynamic_range),
             "full well, or the largest count where that comes first, / floor"}});
  return all;
}

}  // namespace

RoundingNoise rounding_noise(double noise_steps) {
  constexpr double kPi = mtf::kPi, kWhole = 1.0 / 12.0;
  const double s = noise_steps;
  if (s < 0.05) {  // one edge between steps is in reach; what others add is below 1e-40
    const double added = s / std::sqrt(kPi) - s * s, slope = 1.0 / std::sqrt(kPi) - 2.0 * s;
    return {{added, slope}, {kWhole - added, -slope}, 0.0};
  }
  double fixed = 0.0, slope = 0.0, response = 1.0;
  for (int k = 1; k <= 20; ++k) {
    const double part = std::exp(-2.0 * kPi * kPi * k * k * s * s);
    fixed += part * part / (2.0 * kPi * kPi * k * k);
    slope -= 4.0 * s * part * part;
    response += k % 2 == 0 ? 2.0 * part : -2.0 * part;
  }
  return {{kWhole - fixed, -slope}, {fixed, slope}, std::max(0.0, response)};
}

mtf::ValueSlope noise_before_rounding(double temporal_steps2) {
  const auto surplus = [&](double s) { return s * s + rounding_noise(s).temporal.value - temporal_steps2; };
  const double most = std::sqrt(temporal_steps2), s = find_root(surplus, 0.0, most, -temporal_steps2, surplus(most));
  return {s, 1.0 / (2.0 * s + rounding_noise(s).temporal.slope)};
}

void add_rows(std::vector<BudgetRow>& all, BudgetGroup group, std::vector<BudgetRow> rows, bool terms) {
  for (BudgetRow& row : rows) {
    row.group = group;
    row.term = terms;
    all.push_back(std::move(row));
  }
}

void add_spatial_rows(std::vector<BudgetRow>& all, const Budget<double>& b, const std::string& unit,
                      const std::string& dsnu) {
  const std::string corrected = ", after [correction] where given";
  add_rows(all, BudgetGroup::spatial,
           {{"prnu", unit, b.prnu_e, "spatial noise of the responsivity (prnu, or its map)" + corrected},
            {"dsnu", unit, b.dsnu_e, "spatial noise of " + dsnu + corrected},
            {"correction", unit, b.correction_e, "spatial noise of the flat frames of [correction]"},
            {"rounding", unit, b.rounding_e, "rounding to counts, the part that stays where noise does not dither it"}},
           true);
  add_rows(all, BudgetGroup::spatial, {{"spatial", unit, b.spatial_e, "spatial noise, root sum of squares"}});
}

std::vector<BudgetRow> rows(const Budget<double>& budget) {
  std::vector<BudgetRow> all = terms(budget);
  const bool no_flat_frame = !budget.saturation.saturated() && std::isnan(budget.spatial_e);
  for (BudgetRow& row : all) {
    const bool spatial = (row.group == BudgetGroup::spatial && row.name != "rounding") || row.name == "spatial_netd";
    if (row.name == "dynamic_range" && std::isinf(row.value))
      row.refused = budget.floor_e > 0.0 ? "no detector.full_well" : "no noise without light";
    else if (spatial && no_flat_frame)
      row.refused = "no flat frame of [correction] can be made";
    else
      row.refused = refusal_of(budget, row.value);
    row.saturated = is_saturated(budget, row.value);
  }
  return all;
}

bool is_saturated(const Budget<double>& budget, double value) {
  return budget.saturation.saturated() && std::isnan(value);
}

std::string words(const Dither& dither) {
  if (dither.dithered()) return {};
  std::string text = "the noise before the converter is " + mtf::three_digits(dither.noise_steps) +
                     " of a count, which does not dither its rounding (0.4 does): at some levels of the scene ";
  text += dither.response < 0.1 ? "differences of almost a count, " + mtf::three_digits(1e3 * dither.step_k) +
                                      " mK, change nothing in the frames"
                                : "small differences show at " + mtf::three_digits(dither.response) + " of their size";
  return text + "; noise and NETD are means over all levels; give [adc] more bits, or smaller counts";
}

std::string refusal_of(const Budget<double>& budget, double value) {
  if (std::isfinite(value)) return {};
  if (is_saturated(budget, value)) return words(budget.saturation);
  const std::string signal = budget.saturation.volts ? "volts" : "electrons";
  if (!(budget.signal.scene_e > 0.0)) return "no light of the scene makes " + signal;
  if (!(budget.signal_per_k > 0.0)) return "the " + signal + " of the scene do not change with its temperature";
  return "the value is beyond what a number can hold";
}

}  // namespace radiometry
