// SPDX-License-Identifier: Apache-2.0
#include "radiometry/render/band_nodes.h"

#include <algorithm>
#include <cmath>

#include "mtf/error.h"
#include "mtf/math/quadrature.h"
#include "radiometry/light/band_response.h"
#include "radiometry/light/scene_radiance.h"

namespace radiometry::render {
namespace {

constexpr double kAirStep_cm = 5.0;

/// The wavenumbers of the air model from one at or below the range to one at or above it, by rising wavelength.
std::vector<double> air_samples(const Interval& range) {
  std::vector<double> um;
  const double highest = std::ceil(1e4 / range.lo_um / kAirStep_cm),
               lowest = std::floor(1e4 / range.hi_um / kAirStep_cm);
  for (double step = highest; step >= lowest; step -= 1.0) um.push_back(1e4 / (kAirStep_cm * step));
  return um;
}

}  // namespace

BandNodes band_nodes(const SpectralCamera& camera, std::span<const Spectrum> more, int nodes) {
  const std::vector<Spectrum> curves = scene_band(camera).curves;
  BandNodes out{.flux = camera.flux, .range = common_range(camera.band, curves)};
  if (!(out.range.lo_um >= kThermalBands.lo_um && out.range.hi_um <= kThermalBands.hi_um))
    throw mtf::UsageError("a band of " + describe(out.range) + ": pictures of scenes are made from " +
                          describe(kThermalBands) +
                          "; below 3 um the sunlight that air and surfaces scatter would be missing");
  const BandResponse response(camera.band, curves);
  std::vector<Spectrum> cuts = curves;
  cuts.insert(cuts.end(), more.begin(), more.end());
  out.sample_um = air_samples(out.range);
  std::vector<double> edges = union_grid(out.range, cuts);
  for (const double um : out.sample_um)
    if (um > out.range.lo_um && um < out.range.hi_um) edges.push_back(um);
  std::sort(edges.begin(), edges.end());
  std::size_t above = 1;
  for (std::size_t e = 0; e + 1 < edges.size(); ++e) {
    const double lo = edges[e], hi = edges[e + 1];
    if (!(hi > lo)) continue;
    const mtf::GaussRule rule = mtf::mean_rule(lo, hi, nodes);
    for (std::size_t i = 0; i < rule.node.size(); ++i) {
      const double um = rule.node[i];
      while (above + 1 < out.sample_um.size() && out.sample_um[above] < um) ++above;
      out.wavelength_um.push_back(um);
      out.weight.push_back((hi - lo) * rule.weight[i] * response.value(um));
      out.sample.push_back(static_cast<std::uint32_t>(above - 1));
      out.share.push_back((um - out.sample_um[above - 1]) / (out.sample_um[above] - out.sample_um[above - 1]));
    }
  }
  return out;
}

std::vector<double> at_nodes(const BandNodes& nodes, const Spectrum& curve) {
  std::vector<double> values;
  values.reserve(nodes.size());
  for (const double um : nodes.wavelength_um)
    values.push_back(curve.value.size() == 1
                         ? curve.value[0]
                         : evaluate(curve, std::clamp(um, curve.wavelength_um.front(), curve.wavelength_um.back())));
  return values;
}

std::vector<double> blackbody_at(const BandNodes& nodes, double temperature_k) {
  std::vector<double> values(nodes.size(), 0.0);
  if (temperature_k > 0.0)
    for (std::size_t k = 0; k < values.size(); ++k)
      values[k] = planck(nodes.flux, nodes.wavelength_um[k], temperature_k);
  return values;
}

std::vector<double> at_nodes(const BandNodes& nodes, std::span<const double> of_samples) {
  std::vector<double> values(nodes.size());
  for (std::size_t k = 0; k < values.size(); ++k)
    values[k] = std::lerp(of_samples[nodes.sample[k]], of_samples[nodes.sample[k] + 1], nodes.share[k]);
  return values;
}

double integral(const BandNodes& nodes, std::span<const double> values) {
  double sum = 0.0;
  for (std::size_t k = 0; k < values.size(); ++k) sum += nodes.weight[k] * values[k];
  return sum;
}

std::vector<double> fold(const BandNodes& nodes, std::span<const double> values) {
  std::vector<double> out(nodes.samples(), 0.0);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double part = nodes.weight[k] * values[k];
    out[nodes.sample[k]] += (1.0 - nodes.share[k]) * part;
    out[nodes.sample[k] + 1] += nodes.share[k] * part;
  }
  return out;
}

}  // namespace radiometry::render
