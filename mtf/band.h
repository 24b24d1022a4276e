// SPDX-License-Identifier: Apache-2.0
#pragma once

// A band of wavelengths, the electrons that each wavelength gives, and quadrature rules for means over the band:
//   mean of P = integral over the band of w(lambda) P(lambda) dlambda,  w = electron rate per um, its integral being 1
// A P that is smooth over the whole band takes the Gauss rule of the weight w. The OTF of a pupil at one frequency has
// kinks at some wavelengths (where the rims of the pupil and of its image begin or cease to cross, and at the cutoff).
// The band is split there, and each part is integrated over the angle a of lambda = lo + (hi - lo) (1 - cos a) / 2, in
// which the half-integer powers at the ends of a part are smooth.

#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace mtf {

/// Wavelengths and weights that stand for a band, or for a part of it; the weights sum to 1, or to the part's share of
/// the electrons.
struct WavelengthNodes {
  std::vector<double> wavelength_um;
  std::vector<double> weight;
};

/// The electrons over a band (radiometry/light/band_response.h makes it from curves and a source).
class ElectronRate {
 public:
  /// `nodes(n)`: the Gauss rule of n nodes with this weight, positive weights. `density`: share of the electrons per
  /// um. `breaks_um`: rising, from the first wavelength with electrons to the last; between neighbours the density is a
  /// polynomial of degree 8 at most, or Planck's law times one over a ratio of wavelengths of at most 1.15.
  ElectronRate(std::function<WavelengthNodes(int n)> nodes, std::function<double(double wavelength_um)> density,
               std::vector<double> breaks_um);

  WavelengthNodes nodes(int n) const { return nodes_(n); }
  double density(double wavelength_um) const { return density_(wavelength_um); }
  const std::vector<double>& breaks_um() const { return breaks_um_; }

  /// A stretch of the band with a rule for functions that are smooth well beyond it: a curve of thousands of samples
  /// costs no more than one of a few.
  struct Block {
    double begin_um, end_um;
    WavelengthNodes rule;
  };
  const std::vector<Block>& blocks() const { return blocks_; }

 private:
  std::function<WavelengthNodes(int n)> nodes_;
  std::function<double(double wavelength_um)> density_;
  std::vector<double> breaks_um_;
  std::vector<Block> blocks_;
};

/// Wavelength interval with electron-rate weights.
struct Band {
  double lo_um = 0.0;
  double hi_um = 0.0;                                  ///< hi > lo
  std::shared_ptr<const ElectronRate> rate = nullptr;  ///< none: the same rate at every wavelength
};

/// Gauss nodes of a band, inside it, positive weights. n is 1 to kMostGaussNodes.
WavelengthNodes wavelength_nodes(const Band& band, int n);

/// The ends of the parts into which the given kinks split a band, rising, its own ends included; kinks outside of it
/// (or on its ends) split nothing.
std::vector<double> parts_of(const Band& band, std::span<const double> kinks_um);

/// n nodes for the part [begin, end] of a band (within its ends): exact where P is a polynomial of degree n - 1 in the
/// angle, or 2n - 1 without an electron rate. The weights sum to the part's share of the electrons. They may be
/// negative where the rate is ragged. n is 1 to kMostGaussNodes.
WavelengthNodes part_nodes(const Band& band, double begin_um, double end_um, int n);

/// The wavelengths for a mean over a band at any |f|, where kinks lie at certain products of wavelength and frequency.
class BandRule {
 public:
  BandRule() = default;
  /// n nodes for each part; without kinks the Gauss rule of n nodes at every frequency. Kinks in um cycles/mm.
  BandRule(const Band& band, std::vector<double> kinks, int n);

  /// The nodes at |f| = r; `own` is where they are put unless they are those of a whole band.
  const WavelengthNodes& at(double r_cy_mm, WavelengthNodes& own) const;

 private:
  Band band_;
  std::vector<double> kinks_;
  int n_ = 0;
  WavelengthNodes whole_;
};

}  // namespace mtf
