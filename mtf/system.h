// SPDX-License-Identifier: Apache-2.0
#pragma once

// A sensor as a product of OTFs: the frame, the shared optics, the spectral band, and three lists of components.
// The system OTF is exactly the product of what is listed; nothing is implied by [frame], [optics] or [band].
// Chromatic components depend on wavelength: their *product* is averaged over the band with electron-rate weights, then
// multiplied by the rest (averaging each on its own is wrong).

#include <array>
#include <span>
#include <string>
#include <vector>

#include "mtf/band.h"
#include "mtf/component.h"
#include "mtf/field_terms.h"

namespace mtf {

/// A listed component. The label is what reports call it: unique, the kind by default ("jitter", "jitter_2").
template <class S>
struct Entry {
  Component<S> component;
  std::string label;
};

/// Values and the absolute error of their average over the band.
template <class S>
struct Averaged {
  std::vector<Complex<S>> value;
  std::vector<double> error;
};

/// What System::otf() keeps to when it averages over a band, absolute.
inline constexpr double kBandError = 1e-12;

template <class S>
struct System {
  std::string name;
  Frame<S> frame;
  Optics<S> optics;
  PathAir<S> air{};  ///< no part of the OTF by itself
  std::optional<Band> band;
  /// Wavelengths that otf() takes for the band: 0 splits it at the kinks of each frequency and takes as many as
  /// kBandError needs; n is the plain Gauss rule of n nodes. Plans choose their own number from the tolerance.
  int band_nodes = 0;
  std::array<std::vector<Entry<S>>, 3> stages;  ///< index = Stage
  FieldDependence<S> field{};                   ///< numbers of presample components that change over the image
  FieldPoint<S> point{};                        ///< that the OTF is for; the optical axis
  bool settled = false;                         ///< made by at(): that of one field point
  S half_diagonal_um{};                         ///< of the detector; 0: that of the frame's format

  std::vector<Entry<S>>& list(Stage stage) { return stages[static_cast<std::size_t>(stage)]; }
  const std::vector<Entry<S>>& list(Stage stage) const { return stages[static_cast<std::size_t>(stage)]; }

  /// Appends a component with a unique label made from its kind.
  void add(Stage stage, Component<S> component);

  /// One OTF serves the whole image.
  bool is_isoplanatic() const;
  /// The isoplanatic system that a pixel at that field point sees. Its OTF, metrics and fits need nothing else. Without
  /// at(), functions of a system that is not isoplanatic speak of its optical axis. Throws UsageError where a component
  /// depends on the place in um and neither the frame's format nor half_diagonal_um says how large the detector is.
  System at(const FieldPoint<S>& q) const;
  /// What the map of a number has at a field point, in the unit of the number. Throws UsageError outside the positions
  /// of the map, and where they need a size of the detector that nobody says.
  S mapped(const FieldNumber<S>& number, const FieldPoint<S>& q) const;
  /// By what a number differs there from its value on the axis. Throws as mapped().
  S change(const FieldNumber<S>& number, const FieldPoint<S>& q) const;
  /// Half the diagonal of the detector: the unit of field points; 0 where nothing says it.
  S field_radius_um() const;
  /// The field point of a place on the detector, in pixels from its corner; needs the frame's format.
  FieldPoint<S> field_point(double x_px, double y_px) const;

  /// The context of the monochromatic wavelength, or of the band's middle.
  Context<S> context() const;
  Context<S> context(const S& wavelength_um) const;

  /// Product of the given entries at every frequency, chromatic product averaged over the band.
  std::vector<Complex<S>> otf(std::span<const Entry<S>> entries, std::span<const Freq<S>> f) const;
  /// The same with what the average over the band may err by: at most kBandError where that could be had, 0 without a
  /// chromatic entry. With band_nodes given, the errors are NaN: nobody asked how good that rule is.
  Averaged<S> otf_with_error(std::span<const Entry<S>> entries, std::span<const Freq<S>> f) const;
  /// OTF of one component; a chromatic one is averaged over the band on its own (for display only).
  Complex<S> otf(const Entry<S>& entry, const Freq<S>& f) const;
  /// Product of one list, chromatic product averaged over the band. 1 for an empty list.
  Complex<S> otf(Stage stage, const Freq<S>& f) const;
  /// The whole system.
  Complex<S> otf(const Freq<S>& f) const;

  /// What is wrong or doubtful: frame, band, fields, lists. `where` is "frame.pitch_x", "presample[1].rms", …
  struct Finding {
    std::string where;
    Problem problem;
  };
  std::vector<Finding> check() const requires std::same_as<S, double>;
  /// What is wrong, alone: takes a fraction of the time.
  std::vector<Finding> errors() const requires std::same_as<S, double>;
};

/// Throws UsageError with all errors of check() in one message; does nothing when there are only warnings.
void require_valid(const System<double>& system);

/// The numbers that change over the field, as in messages: "presample[0].w131"; "" for an isoplanatic system.
std::string names_over_field(const System<double>& system);
/// Throws UsageError, with those names, unless one OTF serves the whole image: "`what` takes ...".
void require_isoplanatic(const System<double>& system, std::string_view what);

/// The same system in another scalar type.
template <class To, class From>
System<To> cast(const System<From>& system);

extern template struct System<double>;
extern template struct System<float>;
extern template class Component<double>;
extern template class Component<float>;
extern template System<float> cast<float, double>(const System<double>&);

}  // namespace mtf
