// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a camera's band makes of surfaces seen through the air, as tables over what changes from facet to facet and from
// pixel to pixel. With tau and s of node p of a path grid, at the air's wavenumbers i (band_nodes.h):
//   emitted    E(m, T, p) = sum_i tau_pi fold(eps_m B(T))_i            by finish m and temperature T
//   reflected  M(m, l, p) = sum_i tau_pi fold((1 - eps_m) L_l)_i       by finish and source of light l
//   sun        S(m, p)    = sum_i tau_pi fold((1 - eps_m) E_sun / pi)_i
//   path       P(p)       = sum_i s_pi fold(B(T_air))_i
// A pixel is the sum of them, E interpolated in T by cubics through equally spaced temperatures, all in range and
// height by the weights of the grid. Temperatures below 50 K radiate as at 50 K.
//
// The promise covers what interpolation and quadrature err: tables are compared with integrals of twice the nodes and
// air of that very place, at middles between temperatures and at the places of each cell where its parabola is worst,
// and the largest difference is multiplied by kPromise, as places between may be worse. It is relative to the radiance,
// or to that of a blackbody at the temperature of the air where this is more: the air adds as much to a surface that is
// far colder.

#include <algorithm>

#include "radiometry/render/light_sources.h"
#include "radiometry/render/path_grid.h"

namespace radiometry::render {

inline constexpr double kPromise = 2.0;

/// The temperatures that a finish has.
struct KelvinRange {
  double lo_k = 0.0, hi_k = 0.0;
};

/// Those of all finishes, as they come; a finish that none has come for has 300 K.
class KelvinRanges {
 public:
  explicit KelvinRanges(std::size_t finishes) : range_(finishes, {kNone_k, 0.0}) {}
  void take(std::size_t finish, double kelvin) {
    KelvinRange& range = range_[finish];
    range = {std::min(range.lo_k, kelvin), std::max(range.hi_k, kelvin)};
  }
  std::vector<KelvinRange> all() const {
    std::vector<KelvinRange> out = range_;
    for (KelvinRange& one : out)
      if (one.lo_k > one.hi_k) one = {300.0, 300.0};
    return out;
  }

 private:
  static constexpr double kNone_k = 1e9;
  std::vector<KelvinRange> range_;
};

/// Of a cell's six nodes.
using SixValues = std::array<double, 6>;
/// Adds share x values.
inline void add(double share, const SixValues& values, SixValues& sum) {
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += share * values[k];
}
inline SixValues sum_of(SixValues a, const SixValues& b) {
  for (std::size_t k = 0; k < a.size(); ++k) a[k] += b[k];
  return a;
}

/// What depends on temperatures and finishes alone, before the air.
class EmissionFolds {
 public:
  EmissionFolds(const BandNodes& nodes, std::span<const std::vector<double>> emissivity,
                std::span<const KelvinRange> range);

  struct Table {
    double first_k = 0.0, step_k = 1.0;
    std::size_t temperatures = 0;
    std::vector<double> value{};  ///< [temperature * samples + sample]
  };
  const Table& of(std::size_t finish) const { return table_[finish]; }
  std::size_t size() const { return table_.size(); }

 private:
  std::vector<Table> table_;
};

/// Four neighbouring values of a table of equal steps, and the weights of a cubic through them.
struct CubicPlace {
  std::size_t first = 0;
  std::array<double, 4> weight{};
};
/// `at` steps from the first of `of` values.
CubicPlace cubic_place(double at, std::size_t of);
CubicPlace cubic_place(const EmissionFolds::Table& table, double temperature_k);

/// A surface that no side has by itself (band_surfaces.h), at the nodes.
struct MadeFinish {
  std::vector<double> emits{}, reflects{};
  bool light = false;  ///< it reflects all sources, not the sun alone
};

class BandTables {
 public:
  /// `made`: finishes that follow those of `emissivity`; `folds` has them too.
  BandTables(const BandNodes& nodes, const EmissionFolds& folds, std::span<const std::vector<double>> emissivity,
             const LightSources& sources, const PathGrid& grid, double reference_k,
             std::span<const MadeFinish> made = {});

  /// (1 - share) low + share high, of tables on one grid.
  static BandTables between(const BandTables& low, const BandTables& high, double share);

  SixValues emitted(std::size_t finish, double temperature_k, std::size_t node) const;
  /// Adds share x source.
  void add_reflected(std::size_t finish, std::size_t source, double share, std::size_t node, SixValues& sum) const;
  /// Adds the light of sources with their shares, where the finish reflects any.
  template <class Light>
  void add_light(std::size_t finish, const Light& light, std::size_t node, SixValues& sum) const {
    for (std::size_t i = 0; reflects(finish) && i < light.source.size(); ++i)
      add_reflected(finish, light.source[i], static_cast<double>(light.share[i]), node, sum);
  }
  bool reflects(std::size_t finish) const { return !reflected_[finish].empty(); }
  SixValues path(std::size_t node) const { return six(path_, node); }
  /// Of a side that faces the sun; 0 without one.
  SixValues sunlit(std::size_t finish, std::size_t node) const;
  bool sunny() const { return !sun_.empty(); }

 private:
  SixValues six(std::span<const double> of_nodes, std::size_t node) const {
    const double *low = of_nodes.data() + node, *high = low + roots_;
    return {low[0], low[1], low[2], high[0], high[1], high[2]};
  }

  std::size_t nodes_, roots_;
  struct Emitted {
    EmissionFolds::Table place;   ///< without values
    std::vector<double> value{};  ///< [temperature * nodes + node]
  };
  std::vector<Emitted> emitted_;
  std::vector<std::vector<double>> reflected_, sun_;  ///< of each finish: [source * nodes + node], [node]
  std::vector<double> path_;
};

/// The error that is promised for the finishes of `emissivity` in those ranges, relative: see the head of this file.
/// `view`: null without air.
double promised_error(const SpectralCamera& camera, std::span<const Spectrum> emissivity, const EmissionFolds& folds,
                      const BandTables& tables, const PathGrid& grid, const AirView* view);

}  // namespace radiometry::render
