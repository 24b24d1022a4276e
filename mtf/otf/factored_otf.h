// SPDX-License-Identifier: Apache-2.0
#pragma once

// The OTF of one list of a system on a frequency grid, cheaply: H(fx, fy) = R(|f|) X(fx) Y(fy) L(f.u) G(fx, fy).
//   separable components  -> two vectors X and Y
//   radial ones           -> one table R, chromatic ones averaged over the band as a product before they enter it
//   motion at an angle    -> one table each along its direction, L(f.u)
//   slow ones             -> a table in polar coordinates, where the grid is large enough to be worth it
//   all others            -> evaluated per sample in G, a row at a time
// Each component is visited once per vector, table or tile, never per sample.

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mtf/border.h"
#include "mtf/engines/fft/parity.h"
#include "mtf/engines/fft/scene_spectrum.h"
#include "mtf/otf/band_mean.h"
#include "mtf/otf/otf_tables.h"
#include "mtf/otf/split.h"
#include "mtf/otf/taper.h"
#include "mtf/system.h"

namespace mtf {

/// Blur that the scene's samples already carry (a renderer's pixel average). It is divided out of the OTF. 1/A is
/// limited: where |A| < 1/limit per factor the correction is limit^2 A, so it falls with A instead of growing.
struct SceneAperture {
  enum class Kind { point, box, gaussian, curve };
  Kind kind = Kind::point;
  AxisPair<double> size;  ///< box: full width; gaussian: sigma
  std::shared_ptr<const Curve> curve;
  double gain_limit = 10.0;
};

/// A component that was left out before the evaluation, for the plan's report.
struct Dropped {
  std::string label;
  double bound = 0.0;     ///< bound of |otf - 1| over the grid, or its mean over the scene's own spectrum (SceneCost)
  double saved_ms = 0.0;  ///< estimated time that making the OTF would have taken more
};

/// A table that stands for a product of presample components.
struct GivenFactor {
  std::vector<std::size_t> entries;  ///< of the presample list
  std::shared_ptr<const PolarTable> table;
  double largest = 1.0;  ///< bound of its modulus
  double cutoff_cy_mm = std::numeric_limits<double>::infinity();
  Parities parities;
  Parities all;  ///< of all factors with whose OTFs this one is to share its transforms
};

/// What a change of the OTF costs the scene at hand: its rms error, in units in which the largest |change| of any
/// scene's OTF would count. Both are upper bounds, so the smaller of the two is taken.
struct SceneCost {
  const SceneSpectrum* spectrum = nullptr;
  double ratio_x = 1.0, ratio_y = 1.0;  ///< samples a pitch
  double scale = 1.0;                   ///< unit of the spectrum's rms_error
};

/// The threads that make an OTF call this now and then, several at once, with the number of values of slow components
/// that they have made since the last call. An exception from it ends the work.
using OtfProgress = std::function<void(std::int64_t values)>;

struct SamplerOptions {
  double fx_max = 0.0, fy_max = 0.0;  ///< largest |fx| and |fy| of the grid
  double drop_budget = 0.0;           ///< components whose deviations add up to no more are left out
  double table_share = 0.0;  ///< error that a table should not exceed (one that errs by much more is not used);
                             ///< 0: no tables
  int wavelengths = 0;  ///< nodes of a Gauss rule for the band; 0 = split at the kinks, as many as that error needs
  std::int64_t samples = std::numeric_limits<std::int64_t>::max();  ///< about how many frequencies will be asked for
  int threads = 0;                                                  ///< threads that fill tables; 0 = all cores
  std::optional<SceneCost> scene = std::nullopt;
  ScaleSplit split = {};                          ///< the part of the OTF by scale
  Taper taper = {};                               ///< of the OTF beyond the scene's frequencies
  std::shared_ptr<const GivenFactor> given = {};  ///< in place of components
  OtfProgress progress = {};
};

class FactoredOtf {
 public:
  /// Tables of `earlier` (may be null) that hold the same are shared.
  FactoredOtf(const System<double>& system, std::span<const Stage> stages, const SceneAperture& aperture,
              const SamplerOptions& options, const FactoredOtf* earlier = nullptr);
  FactoredOtf(const FactoredOtf&) = delete;  // its lists point into its own copy of the system
  FactoredOtf& operator=(const FactoredOtf&) = delete;

  bool is_real() const { return parities_.is_real(); }
  bool is_even_x() const { return parities_.is_even_x(); }
  bool is_even_y() const { return parities_.is_even_y(); }
  const Parities& parities() const { return parities_; }
  /// Of all OTFs that share its transforms.
  const Parities& all_parities() const { return all_parities_; }
  /// True when H(fx, fy) H(0, 0) = H(fx, 0) H(0, fy): the OTF consists of vectors along the axes.
  bool is_separable() const { return !table_ && lines_.empty() && !has_general(); }
  /// True when some factor is evaluated at every frequency because no table or vector holds it.
  bool is_slow() const { return has_general(); }
  const std::vector<Dropped>& dropped() const { return dropped_; }
  /// Whether leaving them out changes the parts of the OTF alone that it has.
  bool dropped_is_even() const { return dropped_parities_.is_one(); }
  /// Sentences on what was merged: "jitter, footprint -> two vectors".
  const std::vector<std::string>& merged() const { return merged_; }
  /// Bound of |H - 1|, counted as those of the dropped components: what it would cost to leave out everything.
  double identity_error() const { return identity_error_; }
  bool has_gain() const { return gain_ > 1.0; }
  /// Bound of |H|, at least 1: the factor by which amplifying components and the aperture's correction may multiply.
  double gain() const { return gain_ * correction_; }
  int wavelengths() const { return wavelengths_; }
  /// Bound of |H_used - H|, from components that were left out, from tables and from the number of wavelengths.
  double error() const;
  /// The part of it that comes from tables; 0 where every frequency is evaluated.
  double table_error() const;
  /// The part of it that comes from the number of wavelengths: the change when it was last doubled.
  double quadrature_error() const { return (quadrature_error_ + mean_error_) * gain(); }
  /// True when the aperture's correction is at its gain limit for some frequencies of the grid.
  bool aperture_limited() const { return aperture_limited_; }
  /// OTF at zero frequency: the gain of the mean.
  double dc() const { return at({0.0, 0.0}).re; }

  /// The exact value in double; no component is left out.
  Complex<double> at(const Freq<double>& f) const;

  /// Bound of |H| over all frequencies whose component along `axis` is f: for leaving out what no factor lets through.
  double axis_bound(Axis axis, double f_cy_mm) const;

  /// The grid: row j holds H(fx[i], fy[j]) for i = 0 .. count-1. Its axes are fixed; its functions are re-entrant.
  class Grid {
   public:
    Grid(const FactoredOtf& sampler, std::vector<double> fx, std::vector<double> fy);
    Grid(const Grid&) = delete;  // its rows refer to its own frequencies
    Grid& operator=(const Grid&) = delete;
    /// value[i] = H(fx[i], fy[j]), or H(fx[i], -fy[j]) where mirrored; `value` may be shorter than fx. real_row: real
    /// systems only.
    void real_row(std::size_t j, std::span<float> value, bool mirrored = false) const;
    void complex_row(std::size_t j, std::span<Complex<float>> value, bool mirrored = false) const;
    /// The same in double, throughout where the sampler has no tables (table_share = 0).
    void real_row(std::size_t j, std::span<double> value, bool mirrored = false) const;
    void complex_row(std::size_t j, std::span<Complex<double>> value, bool mirrored = false) const;
    /// Makes real_row and its mirror image together, which have most factors in common.
    void real_rows(std::size_t j, std::span<float> value, std::span<float> mirrored) const;
    void real_rows(std::size_t j, std::span<double> value, std::span<double> mirrored) const;

   private:
    /// The factors of a real system that are even along y; multiply_uneven() multiplies by the others.
    void even_row(std::size_t j, std::span<float> value) const;
    void multiply_uneven(std::size_t j, std::span<float> value, bool mirrored) const;
    void multiply_radial(std::size_t j, std::span<float> value) const;
    void multiply_lines(std::size_t j, std::span<float> value, bool mirrored) const;
    /// The product of the factors that no table or vector holds, at fy[j].
    std::vector<Complex<double>> general_row(std::size_t j, std::size_t count, bool mirrored) const;

    const FactoredOtf* sampler_;
    std::vector<double> fx_, fy_;
    std::vector<float> fx2_, fy2_;        ///< squares, in units of the radial table's end
    std::vector<Complex<double>> x_, y_;  ///< product of the separable factors, per axis
    std::vector<Complex<float>> narrow_x_, narrow_y_;
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
  using Entries = std::vector<const Entry<double>*>;
  /// The product of slow components.
  struct Slow {
    Entries of;
    std::shared_ptr<const PolarTable> table;
  };
  static std::string join_labels(const Entries& entries);
  static bool same_components(const Entries& a, const Entries& b);
  bool asks_for_same_tables(const FactoredOtf& other) const;
  void sort_components();
  bool is_given(Stage stage, std::size_t entry) const;
  void take_given();
  double scene_cost(const Entry<double>& entry) const;
  void bound_correction();
  std::string radial_labels() const;
  /// Calls `value(i)` for every i below `count`; by threads for means over the band, as others are too quick for them.
  void for_each(std::size_t count, const std::function<void(std::size_t)>& value) const;
  void tabulate_radial(double end, double target);
  void tabulate_lines(double target);
  void tabulate_slow(double target, const FactoredOtf* earlier);
  Complex<double> chromatic_product(const Freq<double>& f) const;
  /// The product of chromatic components at one wavelength.
  Complex<double> product_at(const Freq<double>& f, double wavelength_um) const;
  std::vector<double> chromatic_kinks() const;
  void choose_wavelengths(double end, double target);
  void tabulate_band(double end);
  PolarTable::Rings reported(PolarTable::Rings rings) const;
  PolarTable::Rings band_rings(double end, double target) const;
  double radial_product(double r) const;
  bool has_general() const {
    return radial_per_sample_ || !general_.empty() || !chromatic_general_.empty() || !polar_.empty();
  }
  double aperture_mtf(Axis axis, double f) const;  ///< the scene's own blur along one axis
  double aperture_mtf(double r) const;             ///< and of a radial curve
  double aperture_factor(Axis axis, double f) const;
  double aperture_radial(double r) const;

  System<double> system_;
  SceneAperture aperture_;
  std::vector<Stage> stages_;
  SamplerOptions options_;
  Entries entries_, separable_, radial_, chromatic_radial_, general_, chromatic_general_;
  Entries averaged_;         ///< chromatic components, whose product is averaged over the band
  double gain_ = 1.0;        ///< bound of the product of the components that amplify
  double correction_ = 1.0;  ///< bound of the aperture's correction
  double identity_error_ = 0.0;
  std::vector<Dropped> dropped_;
  std::vector<std::string> merged_;
  BandRule wavelength_rule_;
  std::optional<BandMean> radial_mean_;  ///< mean of the slow radial components
  std::shared_ptr<const RadialTable> table_;
  std::vector<Line> lines_;
  std::vector<Slow> polar_;
  double cutoff_ = std::numeric_limits<double>::infinity();  ///< |f| from which some component lets nothing through
  Parities parities_, all_parities_, dropped_parities_;
  bool aperture_limited_ = false;
  bool radial_per_sample_ = false;  ///< no table resolves the radial factors
  double quadrature_error_ = 0.0;
  double mean_error_ = 0.0;  ///< of radial_mean_
  int wavelengths_ = 1;
};

}  // namespace mtf
