// SPDX-License-Identifier: Apache-2.0
#pragma once

// Temperatures of all surfaces of a scene over a run.
//
//   scene -> weather, sun, sky over time -> rays: shadows, views, units, exchange
//   -> heat balance of every unit -> temperatures of facets at the outputs
//
// Units exchange long-wave radiation, so the balance of one needs the temperatures of the others. They are found by
// iteration over windows of a day: all units are solved with the irradiance that the last iteration's temperatures
// give, until that irradiance changes by less than a share of the tolerance. The first day is also the one that the
// start repeats (radiometry/heat/periodic.h).

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "radiometry/thermal/run/solve_units.h"

namespace radiometry::thermal {

// The realised error of a run: its temperatures against those of runs at a tenth of the tolerance, with the nodes that
// this tolerance asks for, the same patches and the same rays to other surfaces. The sun is traced anew, from other
// points of the facets, four times as many, and at least every few minutes:
//   as units     the same units: steps, cells, depth, the start, the iteration of the exchange and its parabolas, which
//                the promise is about. Sides that nothing ever shades are in the sun whenever it is before them,
//                whatever the table of shadows says of them; others keep their table
//   by itself    every facet a unit, in the sun as it was traced anew: what merging and the table of shadows do too,
//                which is measured beside the promise (ViewSpread, table_error.h)
//
// Where only what the camera sees is asked for, both solve the whole scene, the second one with all rays of what is not
// seen, and what is seen is compared.

/// Of all facets at all outputs, fronts and backs.
struct RealisedError {
  double rms_k = 0.0;
  double percentile_95_k = 0.0, percentile_999_k = 0.0;  ///< over facets, of the largest error of each
  double largest_k = 0.0;
  std::uint32_t facet = 0;  ///< that has the largest
  double time_s = 0.0;      ///< when, from the start of the run
  double promised_k = 0.0;  ///< of the run that is taken for the truth
  std::size_t count = 0;    ///< facets
};

struct Verification {
  RealisedError as_units;  ///< what the promise is about
  RealisedError by_itself;
  double ms = 0.0;
};

/// Temperatures of a run, kept to be compared: single precision about 300 K, which is 2e-5 K at 600 K.
struct KeptOutputs {
  std::vector<float> front, back;  ///< [output * facets + facet], K - 300
  void keep(const HeatOutput& output);
};

/// `kept` holds all outputs of the scene. Nothing when options.go_on ended a run before.
std::optional<Verification> verify_heat(const HeatScene& scene, const Units& units, const HeatOptions& options,
                                        const KeptOutputs& kept, const HeatProgress& progress);

struct HeatReport : UnitsRun {
  std::size_t facets = 0, units = 0, patches = 0;
  std::vector<std::uint32_t> covered{};  ///< facets that lie inside other solids and see nothing else
  scene::ViewError view_error{};
  scene::SunError sun_error{};
  std::optional<Verification> verified{};  ///< where the options ask for it and the run went to its end
  std::vector<std::pair<std::string, double>> timing_ms{};
  std::vector<std::string> warnings{};
};

/// Calls `output` for every output time, in order, and `progress` with the share that is done. A promise above the
/// tolerance is told by the report. Throws RuntimeError when the exchange between surfaces does not converge and when a
/// temperature is one that no surface has.
HeatReport run_heat(
    const HeatScene& scene, const HeatOptions& options, const HeatOutputs& output,
    const HeatProgress& progress = [](const std::string&, double) {});

}  // namespace radiometry::thermal
