// SPDX-License-Identifier: Apache-2.0
#pragma once

// The sensor under every condition, with derivatives of its OTF by the fitted parameters: H(f) as Jets, four parameters
// an evaluation. The direction of a slice is one more variable, for the angle of an edge in blur that is not round.
// Where the OTF changes over the field, data see the system of their place in the image, System::at of it: derivatives
// reach the terms of its numbers and the optical axis through the field point.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calib/edge/edge_curve.h"
#include "calib/edge/step_response.h"
#include "calib/fit/system_jet.h"

namespace calib {

/// A frequency in cycles per pixel, along rows and columns, and its derivative by one further variable.
struct PixelFreq {
  double x = 0.0, y = 0.0;
  double dx = 0.0, dy = 0.0;
};

/// h[0] = H(f) / H(0); h[1 + i] its derivative by parameter i; the last one that by the variable of PixelFreq.
using OtfTable = std::vector<std::vector<mtf::Complex<double>>>;

class Sensors {
 public:
  /// The paths have to exist in all conditions, each of which holds its own numbers (parameter_site).
  Sensors(std::span<const mtf::System<double>> conditions, std::span<const std::string> paths);
  Sensors(const Sensors&) = delete;
  Sensors& operator=(const Sensors&) = delete;

  std::size_t parameters() const { return count_; }
  /// Sets the parameters in all conditions. False when a condition does not allow them (System::check).
  bool set(std::span<const double> values);
  /// Changes when the parameters do.
  std::size_t version() const { return version_; }
  const mtf::System<double>& system(std::size_t condition) const { return systems_[condition]; }

  /// The index, for all functions below, of what data see that were taken under a condition at a place in the image,
  /// the mean over `points`, in pixels from the detector's corner: that of the condition itself, unless its OTF changes
  /// over the field. The condition's own index stands for the optical axis. Throws UsageError where the size of the
  /// detector is not known.
  std::size_t place(std::size_t condition, std::vector<Point> points);
  /// The middle of it; nothing for a condition itself.
  std::optional<mtf::FieldPoint<double>> field_point(std::size_t place) const;

  /// Whether a parameter acts differently over the field, at the present values: a term of a number, the value on the
  /// axis of one that has a term or a table, or the place of the axis.
  bool varies_over_field(std::size_t parameter) const;

  /// `unit`: of f, where that is not cy/px; the present frame converts it, and its numbers may be parameters.
  OtfTable otf(std::size_t place, std::span<const PixelFreq> f, const mtf::Unit* unit = nullptr) const;
  /// H at frequency 0, to which all others are relative.
  double response_at_zero(std::size_t place) const;
  /// |H| only.
  std::vector<double> modulus(std::size_t place, std::span<const PixelFreq> f) const;

  /// Frequencies for the step response along a normal: up to the cutoff, or to where less than 1e-8 of H is left, 32
  /// cycles/px at most.
  SliceNodes slice(std::size_t place, double angle_rad, double range_px) const;
  /// The frequency above which H is taken as 0, along that direction.
  double top_cy_px(std::size_t place, double angle_rad) const;

 private:
  struct Seeded {
    mtf::System<Jet4> system;
    std::vector<std::vector<Jet4*>> numbers;  // of every parameter
  };
  struct Place {
    std::size_t condition = 0;
    std::vector<Point> points{};  // none: the optical axis
  };
  /// What is seen from the points of a place, the first of which stands for limits.
  template <class S>
  static std::vector<mtf::System<S>> seen_from(const Place& place, const mtf::System<S>& system);
  std::vector<mtf::System<double>> seen_at(std::size_t place) const;

  std::size_t count_ = 0;
  std::size_t version_ = 0;
  bool allowed_ = true;
  std::vector<double> values_;
  std::vector<mtf::System<double>> systems_;
  std::vector<std::vector<std::vector<double*>>> numbers_;  // [condition][parameter]
  std::vector<std::vector<Seeded>> jets_;                   // [condition][four parameters]
  std::vector<Place> places_;                               // the conditions, then places in the image
};

/// Frequencies of a slice in the direction of an angle from +x to +y, with their derivative by the angle.
std::vector<PixelFreq> along(double angle_rad, std::span<const double> f_cy_px);

}  // namespace calib
