// SPDX-License-Identifier: Apache-2.0
#pragma once

// The components of a presample list whose OTF changes over the image: their product at any place of the image, as
// tables over radius and direction (mtf/otf/otf_tables.h) with the same breaks. Of a system whose OTF only turns with
// the direction of the field point and depends on its distance besides, a few tables along a radius serve all places.
// Where rims cut the pupil the OTF has kinks along the radius: it is parted there, and each panel has Chebyshev points
// of its own.

#include <complex>
#include <span>
#include <vector>

#include "mtf/field/field_modes.h"
#include "mtf/math/barycentric.h"
#include "mtf/otf/otf_tables.h"

namespace mtf {

class FieldTables {
 public:
  /// `outline`: places that tell how far in frequency the OTFs reach over the image, and where they have kinks;
  /// `end_cy_mm`: largest |f| asked for.
  FieldTables(const System<double>& system, std::span<const FieldPoint<double>> outline, double end_cy_mm,
              const FieldModesOptions& options);

  /// Makes what the OTFs at these places take; places that were asked for before cost nothing.
  void prepare(std::span<const FieldPoint<double>> places);
  /// The OTF at place i of the last ones.
  PolarTable at(std::size_t place) const;
  /// Sum of weight[i] times the OTF at place i.
  PolarTable sum(std::span<const double> weight) const;
  /// Bound of |table - OTF| at each of the places, by their makers.
  double error() const { return error_; }
  /// The tables along the radius, whose sum is the OTF at a place (angle 0: on +x), where the radius is parted: then
  /// OTFs are not smooth over the image, and polynomials do not follow them.
  bool is_parted() const { return panels_.size() > 1; }
  std::vector<double> kinks() const;
  std::span<const PolarTable> along_radius() const { return tables_; }
  struct Share {
    std::size_t table;
    double weight;
  };
  std::vector<Share> shares_at(double radius) const;

  /// Whether the OTFs at that many more places would take longer than anyone would wait.
  bool is_dear(std::size_t places) const;

  /// What every table of a sum stands for: components, cutoff, parities of all.
  const GivenFactor& factor() const { return factor_; }
  /// The system with as many wavelengths as the average of these components over the band takes, and what it errs.
  const System<double>& system() const { return system_; }
  double band_error() const { return band_error_; }

 private:
  class ComponentsAt;
  /// Of a radius, and its points with their tables.
  struct Panel {
    double begin = 0.0, end = 0.0;
    Barycentric points{};
    std::vector<std::size_t> tables{};
    double at(double t) const { return 0.5 * ((1.0 - t) * begin + (1.0 + t) * end); }  // t in -1 .. 1
  };
  /// The OTF at a place: a sum of tables, turned.
  struct Place {
    FieldPoint<double> q;
    std::vector<Share> shares;
    double angle = 0.0;
  };
  std::vector<Freq<double>> some_frequencies() const;
  void choose_band_nodes(std::span<const FieldPoint<double>> places, double target);
  bool turns(double farthest) const;
  std::vector<double> kinks_of_radius(double farthest) const;
  void try_radius(double farthest);
  double fill(Panel& panel, std::vector<double>& radii, double target);
  PolarTable table_of(const ComponentsAt& part, double target);
  PolarTable combined(std::span<const std::size_t> places, std::span<const double> weight) const;

  System<double> system_;
  FieldModesOptions options_;
  bool slow_ = false, chromatic_ = false;
  double end_ = 0.0, wavelengths_ = 1.0;
  std::vector<double> breaks_;
  GivenFactor factor_;
  std::vector<PolarTable> tables_;
  std::vector<Panel> panels_;  ///< where tables are those of a radius
  std::vector<Place> places_;
  std::vector<std::size_t> last_;  ///< of places_
  double error_ = 0.0, band_error_ = 0.0;
  std::int64_t values_ = 0;  ///< of an OTF, that were made
  std::int64_t bytes_ = 0;   ///< of the tables, where each place has its own
};

/// By how much interpolation between n Chebyshev points may enlarge an error of the values.
double lebesgue(std::size_t n);

}  // namespace mtf
