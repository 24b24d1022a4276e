// SPDX-License-Identifier: Apache-2.0
#pragma once

// The OTF of one list of a system on a frequency grid, cheaply: H(fx, fy) = R(|f|) X(fx) Y(fy) L(f.u) G(fx, fy).
//   separable components  -> two vectors X and Y
//   radial ones           -> one table R, chromatic ones averaged over the band as a product before they enter it
//   motion at an angle    -> one table each along its direction, L(f.u)
//   all others            -> evaluated per sample in G, a row at a time
// Each component is visited once per vector, table or tile, never per sample.

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mtf/border.h"
#include "mtf/radial_table.h"
#include "mtf/system.h"

namespace mtf {

/// Blur that the scene's samples already carry (a renderer's pixel average); divided out of the OTF. 1/A is limited:
/// where |A| < 1/limit per factor the correction is limit^2 A, so it falls with A instead of growing.
struct SceneAperture {
  enum class Kind { point, box, gaussian, curve };
  Kind kind = Kind::point;
  AxisPair<double> size;  ///< box: full width; gaussian: sigma
  std::shared_ptr<const Curve> curve;
  double gain_limit = 10.0;
};

/// What was put aside before evaluation, for the plan's report.
struct Dropped {
  std::string label;
  double bound = 0.0;  ///< of |otf - 1| over the grid
};

class OtfSampler {
 public:
  /// Prepares `stages` of `system` for |fx| <= fx_max, |fy| <= fy_max. Components whose deviations add up to no more
  /// than `drop_budget` are left out. `table_share` is the error that
  /// radial factors should not exceed; a table that errs by much more is not used. `wavelengths` of the band: 0 = as
  /// many as that error needs.
  OtfSampler(const System<double>& system, std::span<const Stage> stages, const SceneAperture& aperture, double fx_max,
             double fy_max, double drop_budget, double table_share, int wavelengths = 0);
  OtfSampler(const OtfSampler&) = delete;  // its lists point into its own copy of the system
  OtfSampler& operator=(const OtfSampler&) = delete;

  bool is_real() const { return real_; }
  bool is_even_x() const { return even_x_; }
  bool is_even_y() const { return even_y_; }
  bool is_identity() const { return entries_.empty() && aperture_.kind == SceneAperture::Kind::point; }
  const std::vector<Dropped>& dropped() const { return dropped_; }
  /// Sentences on what was merged: "jitter, footprint -> two vectors".
  const std::vector<std::string>& merged() const { return merged_; }
  bool has_gain() const { return gain_ > 1.0; }
  /// Bound of |H|, at least 1: what amplifying components and the aperture's correction may multiply.
  double gain() const { return gain_ * correction_; }
  int wavelengths() const { return wavelengths_; }
  /// Bound of |H_used - H| from dropping and from the table.
  double error() const;
  /// The part of it that comes from the number of wavelengths: the change when it was last doubled.
  double quadrature_error() const { return quadrature_error_ * gain(); }
  /// Some frequencies on the grid hit the aperture's gain limit.
  bool aperture_limited() const { return aperture_limited_; }
  /// OTF at zero frequency: the gain of the mean.
  double dc() const { return at({0.0, 0.0}).re; }

  /// Exact value in double, nothing dropped.
  Complex<double> at(const Freq<double>& f) const;

  /// Bound of |H| over all frequencies whose component along `axis` is f: for leaving out what no factor lets through.
  double axis_bound(Axis axis, double f_cy_mm) const;

  /// The grid: row j holds H(fx[i], fy[j]) for i = 0 .. count-1. One sampler of fixed axes; const and re-entrant.
  class Grid {
   public:
    Grid(const OtfSampler& sampler, std::vector<double> fx, std::vector<double> fy);
    Grid(const Grid&) = delete;  // its rows look at its own frequencies
    Grid& operator=(const Grid&) = delete;
    /// value[i] = H(fx[i], fy[j]), real systems only. `value` may be shorter than fx.
    void real_row(std::size_t j, std::span<float> value) const;
    void complex_row(std::size_t j, std::span<Complex<float>> value) const;

   private:
    void multiply_tables(std::size_t j, std::span<float> value) const;
    /// What no table or vector holds, at fy[j].
    std::vector<Complex<double>> general_row(std::size_t j, std::size_t count) const;

    const OtfSampler* sampler_;
    std::vector<double> fx_, fy_;
    std::vector<float> fx2_, fy2_;  ///< squares, in units of the radial table's end
    std::vector<Complex<float>> x_, y_;
    std::vector<std::vector<float>> line_x_, line_y_;  ///< parts of f.u in units of each line table's end
    std::vector<Component<double>::Rows> rows_;
  };

 private:
  friend class Grid;
  /// A real factor of f.u alone.
  struct Line {
    Freq<double> direction;
    RadialTable table;
  };
  void sort_components(double fx_max, double fy_max, double drop_budget);
  void bound_correction(double fx_max, double fy_max);
  void tabulate_lines(double fx_max, double fy_max, double table_share, double target);
  void choose_wavelengths(double end, double target, int wanted);
  double radial_product(double r) const;
  bool has_general() const { return radial_per_sample_ || !general_.empty() || !chromatic_general_.empty(); }
  double aperture_mtf(Axis axis, double f) const;  ///< the scene's own blur along one axis
  double aperture_mtf(double r) const;             ///< and of a radial curve
  double aperture_factor(Axis axis, double f) const;
  double aperture_radial(double r) const;

  System<double> system_;
  SceneAperture aperture_;
  std::vector<Stage> stages_;
  std::vector<const Entry<double>*> entries_, separable_, radial_, chromatic_radial_, general_, chromatic_general_;
  double gain_ = 1.0;        ///< bound of the product of the components that amplify
  double correction_ = 1.0;  ///< bound of the aperture's correction
  std::vector<Dropped> dropped_;
  std::vector<std::string> merged_;
  WavelengthNodes nodes_;
  std::optional<RadialTable> table_;
  std::vector<Line> lines_;
  bool real_ = true, even_x_ = true, even_y_ = true, aperture_limited_ = false;
  bool radial_per_sample_ = false;  ///< no table resolves the radial factors
  double quadrature_error_ = 0.0;
  int wavelengths_ = 1;
};

}  // namespace mtf
