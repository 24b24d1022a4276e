// SPDX-License-Identifier: Apache-2.0
#pragma once

// The realised error of a run: its temperatures against those of runs at a tenth of the tolerance, with the nodes that
// this tolerance asks for, the same patches and the same rays to other surfaces. The sun is traced anew, from other
// points of the facets, four times as many, and at least every few minutes:
//   as units     the same units: steps, cells, depth, the start, the iteration of the exchange and its parabolas, which
//                the promise is about. Sides that nothing ever shades are in the sun whenever it is before them,
//                whatever the table of shadows says of them; others keep their table
//   by itself    every facet a unit, in the sun as it was traced anew: what merging and the table of shadows do too,
//                which is measured beside the promise (view_spread.h, table_error.h)
//
// Where only what the camera sees is asked for, both solve the whole scene, the second one with all rays of what is not
// seen, and what is seen is compared.

#include <cstdint>
#include <optional>
#include <vector>

#include "radiometry/thermal/run/solve_units.h"

namespace radiometry::thermal {

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

}  // namespace radiometry::thermal
