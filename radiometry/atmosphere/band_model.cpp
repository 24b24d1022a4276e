// SPDX-License-Identifier: Apache-2.0
#include "radiometry/atmosphere/band_model.h"

#include <algorithm>
#include <cmath>

namespace radiometry::atmosphere {
namespace {

struct BandRun {
  std::size_t band, first, count;
};

#include "radiometry/atmosphere/tables/coefficients.inc"

static_assert(std::size(kBands) == kLineBands);
static_assert(std::size(kAerosolWavelength_um) == kAerosolNodes);

BandModel make_model() {
  BandModel model;
  model.lines.resize(kLineBands);
  model.values.reserve(std::size(kLogC));
  const int* log_c = std::begin(kLogC);
  for (const BandRun& run : kRuns) {
    const double* start = model.values.data() + model.values.size();
    for (std::size_t i = 0; i < run.count; ++i) model.values.push_back(std::exp(1e-5 * kBands[run.band].a * *log_c++));
    model.lines[run.band].push_back({run.first, {start, run.count}});
  }
  model.water_foreign = {0, kWaterForeign};
  model.water_self_296 = {0, kWaterSelf296};
  model.water_self_260 = {0, kWaterSelf260};
  model.nitrogen = {kNitrogenFirst, kNitrogen};
  for (std::size_t i = 0; i < 3; ++i) model.oxygen[i] = {kOxygenFirst, kOxygen[i]};
  for (std::size_t i = 0; i < kWavenumbers; ++i) {
    const double nu = wavenumber_cm(i), um = 1e4 / nu;
    model.molecules.push_back(nu * nu * nu * nu / (kRayleighA - kRayleighB * nu * nu));
    const auto above = std::upper_bound(std::begin(kAerosolWavelength_um) + 1, std::end(kAerosolWavelength_um) - 1, um);
    model.aerosol_node.push_back(static_cast<int>(above - std::begin(kAerosolWavelength_um)) - 1);
    model.aerosol_share.push_back(std::clamp((um - above[-1]) / (above[0] - above[-1]), 0.0, 1.0));
  }
  return model;
}

}  // namespace

double wavenumber_cm(std::size_t index) {
  const auto i = static_cast<double>(index);
  return index < kEmissionWavenumbers ? 650.0 + 5.0 * i
                                      : 3520.0 + 20.0 * (i - static_cast<double>(kEmissionWavenumbers));
}

std::span<const BandLaw> band_laws() { return kBands; }

Component component_of(Gas gas) {
  using enum Component;
  constexpr std::array<Component, kGases> kComponentOf{water_lines,     carbon_dioxide, ozone,       nitrous_oxide,
                                                       carbon_monoxide, methane,        oxygen,      trace_gases,
                                                       trace_gases,     trace_gases,    trace_gases, nitric_acid};
  return kComponentOf[static_cast<std::size_t>(gas)];
}

const BandModel& band_model() {
  static const BandModel model = make_model();
  return model;
}

double haze_humidity_share() { return kHazeHumidityShare; }
AerosolSpectrum haze_spectrum(HazeKind kind, AerosolLoss loss, std::size_t humidity) {
  const auto& spectra = loss == AerosolLoss::extinction ? kHazeSpectra : kHazeAbsorption;
  return AerosolSpectrum(spectra[static_cast<std::size_t>(kind) - static_cast<std::size_t>(HazeKind::rural)][humidity]);
}
AerosolSpectrum fog_spectrum(HazeKind kind, AerosolLoss loss) {
  const auto& spectra = loss == AerosolLoss::extinction ? kFogSpectra : kFogAbsorption;
  return AerosolSpectrum(spectra[kind == HazeKind::advection_fog ? 0 : 1]);
}
AerosolSpectrum upper_spectrum(AerosolRegion region, AerosolLoss loss) {
  const auto& spectra = loss == AerosolLoss::extinction ? kUpperSpectra : kUpperAbsorption;
  return AerosolSpectrum(spectra[static_cast<std::size_t>(region) - 1]);
}

double boundary_aerosol(std::size_t visibility, std::size_t altitude) { return kBoundaryAerosol[visibility][altitude]; }
double tropospheric_aerosol(Season season, std::size_t visibility, std::size_t altitude) {
  return kTroposphericAerosol[static_cast<std::size_t>(season)][visibility][altitude];
}
double stratospheric_aerosol(Season season, std::size_t altitude) {
  return kStratosphericAerosol[static_cast<std::size_t>(season)][altitude];
}
double upper_aerosol(std::size_t altitude) { return kUpperAerosol[altitude]; }

}  // namespace radiometry::atmosphere
