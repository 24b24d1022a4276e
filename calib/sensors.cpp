// SPDX-License-Identifier: Apache-2.0
#include "calib/sensors.h"

#include <algorithm>
#include <cmath>

#include "calib/parameter_site.h"
#include "mtf/error.h"

namespace calib {
namespace {

using mtf::Complex;
using mtf::Freq;
using mtf::Stage;
using mtf::System;

constexpr std::size_t kStride = 4;
constexpr double kNothingLeft = 1e-8;
constexpr double kMostTop_cy_px = 32.0;
constexpr double kBandError = 1e-7;

template <class S>
std::vector<Complex<S>> product(const System<S>& system, std::span<const Freq<S>> f) {
  std::vector<Complex<S>> h(f.size(), {S(1), S(0)});
  for (const Stage stage : mtf::kStages) {
    if (system.list(stage).empty()) continue;
    const auto part = system.otf(std::span(system.list(stage)), f);
    for (std::size_t i = 0; i < f.size(); ++i) h[i] = h[i] * part[i];
  }
  return h;
}

template <class S>
Freq<S> to_focal_plane(const mtf::Frame<S>& frame, const S& x, const S& y, const mtf::Unit* unit) {
  if (unit == nullptr) return {frame.cy_mm_from_px(x, mtf::Axis::x), frame.cy_mm_from_px(y, mtf::Axis::y)};
  return {mtf::SpatialFrequency<S>{x, unit}.cy_mm(frame, mtf::Axis::x),
          mtf::SpatialFrequency<S>{y, unit}.cy_mm(frame, mtf::Axis::y)};
}

std::vector<Freq<double>> to_focal_plane(const System<double>& system, std::span<const PixelFreq> f) {
  std::vector<Freq<double>> all;
  all.reserve(f.size());
  for (const PixelFreq& p : f)
    all.push_back({system.frame.cy_mm_from_px(p.x, mtf::Axis::x), system.frame.cy_mm_from_px(p.y, mtf::Axis::y)});
  return all;
}

/// Cycles/mm in one cycle/px along a direction.
double scale_of(const System<double>& system, double angle_rad) {
  return std::hypot(system.frame.cy_mm_from_px(std::cos(angle_rad), mtf::Axis::x),
                    system.frame.cy_mm_from_px(std::sin(angle_rad), mtf::Axis::y));
}

/// Contexts at which the components have their limits: the band's ends, or the one wavelength.
std::vector<mtf::Context<double>> contexts(const System<double>& system) {
  if (!system.band) return {system.context()};
  return {system.context(system.band->lo_um), system.context(system.band->hi_um)};
}

double obscuration_of(const mtf::Component<double>& component, const mtf::Context<double>& context) {
  for (const auto& field : component.fields())
    if (field.info->name == "obscuration")
      if (const auto* own = std::get_if<std::optional<double>*>(&field.value))
        return (*own)->value_or(context.optics.obscuration.value_or(0.0));
  return 0.0;
}

}  // namespace

std::vector<PixelFreq> along(double angle_rad, std::span<const double> f_cy_px) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  std::vector<PixelFreq> all;
  all.reserve(f_cy_px.size());
  for (const double f : f_cy_px) all.push_back({f * c, f * s, -f * s, f * c});
  return all;
}

Sensors::Sensors(std::span<const System<double>> conditions, std::span<const std::string> paths)
    : count_(paths.size()), systems_(conditions.begin(), conditions.end()) {
  for (std::size_t c = 0; c < systems_.size(); ++c) {
    auto& numbers = numbers_.emplace_back();
    for (const std::string& path : paths) numbers.push_back(parameter_site(systems_[c], path).numbers);
    choose_band_nodes(c);
    auto& seeded = jets_.emplace_back(count_ / kStride + 1);  // the direction is one more variable
    for (std::size_t chunk = 0; chunk < seeded.size(); ++chunk) {
      seeded[chunk].system = mtf::cast<Jet4>(systems_[c]);
      for (std::size_t i = 0; i < count_; ++i) {
        seeded[chunk].numbers.push_back(parameter_site(seeded[chunk].system, paths[i]).numbers);
        if (i / kStride != chunk) continue;
        for (Jet4* number : seeded[chunk].numbers.back()) number->v[static_cast<Eigen::Index>(i % kStride)] = 1.0;
      }
    }
  }
}

// As many as the mean over the band needs, at the values there are now: doubled until nothing changes.
void Sensors::choose_band_nodes(std::size_t condition) {
  System<double>& system = systems_[condition];
  if (!system.band) return;
  std::vector<double> f;
  const double top = top_cy_px(condition, 0.0);
  for (int i = 1; i < 32; ++i) f.push_back(top * i / 32.0);
  const std::vector<Freq<double>> at = to_focal_plane(system, along(0.0, f));
  std::vector<Complex<double>> before;
  for (system.band_nodes = 4; system.band_nodes <= 256; system.band_nodes *= 2) {
    const std::vector<Complex<double>> h = product<double>(system, at);
    double change = before.empty() ? 1.0 : 0.0;
    for (std::size_t i = 0; i < before.size(); ++i)
      change = std::max(change, std::hypot(h[i].re - before[i].re, h[i].im - before[i].im));
    if (change < kBandError) return;
    before = h;
  }
  system.band_nodes = 256;
}

bool Sensors::set(std::span<const double> values) {
  if (std::equal(values.begin(), values.end(), values_.begin(), values_.end())) return allowed_;
  values_.assign(values.begin(), values.end());
  ++version_;
  allowed_ = true;
  for (std::size_t c = 0; c < systems_.size(); ++c) {
    for (std::size_t i = 0; i < count_; ++i) {
      for (double* number : numbers_[c][i]) *number = values[i];
      for (Seeded& seeded : jets_[c])
        for (Jet4* number : seeded.numbers[i]) number->a = values[i];
    }
    for (const auto& finding : systems_[c].check()) allowed_ = allowed_ && !finding.problem.error;
  }
  return allowed_;
}

OtfTable Sensors::otf(std::size_t condition, std::span<const PixelFreq> f, const mtf::Unit* unit) const {
  const std::size_t n = f.size();
  OtfTable table(count_ + 2, std::vector<Complex<double>>(n));
  std::vector<Freq<Jet4>> at(n + 1);
  for (std::size_t chunk = 0; chunk < jets_[condition].size(); ++chunk) {
    const System<Jet4>& system = jets_[condition][chunk].system;
    const std::size_t first = chunk * kStride, last = std::min(first + kStride, count_ + 1);
    at[0] = {Jet4(0.0), Jet4(0.0)};  // the level
    for (std::size_t i = 0; i < n; ++i) {
      Jet4 x(f[i].x), y(f[i].y);
      if (last == count_ + 1) {
        x.v[static_cast<Eigen::Index>(count_ - first)] = f[i].dx;
        y.v[static_cast<Eigen::Index>(count_ - first)] = f[i].dy;
      }
      at[i + 1] = to_focal_plane(system.frame, x, y, unit);
    }
    const std::vector<Complex<Jet4>> h = product<Jet4>(system, at);
    const Jet4 level = h[0].re;
    for (std::size_t i = 0; i < n; ++i) {
      const Jet4 re = h[i + 1].re / level, im = h[i + 1].im / level;
      table[0][i] = {re.a, im.a};
      for (std::size_t k = first; k < last; ++k) {
        const auto lane = static_cast<Eigen::Index>(k - first);
        table[k + 1][i] = {re.v[lane], im.v[lane]};
      }
    }
  }
  return table;
}

std::vector<double> Sensors::modulus(std::size_t condition, std::span<const PixelFreq> f) const {
  std::vector<PixelFreq> with_level{{}};
  with_level.insert(with_level.end(), f.begin(), f.end());
  const auto h = product<double>(systems_[condition], to_focal_plane(systems_[condition], with_level));
  std::vector<double> all;
  for (std::size_t i = 1; i < h.size(); ++i) all.push_back(std::hypot(h[i].re, h[i].im) / std::abs(h[0].re));
  return all;
}

double Sensors::top_cy_px(std::size_t condition, double angle_rad) const {
  const System<double>& system = systems_[condition];
  double top = kMostTop_cy_px;
  for (const Stage stage : mtf::kStages)
    for (const auto& entry : system.list(stage)) {
      double cutoff = 0.0;  // of a chromatic one: that of the shortest wavelength
      for (const auto& context : contexts(system)) cutoff = std::max(cutoff, entry.component.cutoff_cy_mm(context));
      top = std::min(top, cutoff / scale_of(system, angle_rad));
    }
  // Where nothing cuts off, the product fades. Steps too small to fall between the zeros of one factor for long.
  std::vector<double> f;
  for (double here = 0.25; here < top; here *= 1.06) f.push_back(here);
  if (f.empty()) return top;
  const std::vector<double> h = modulus(condition, along(angle_rad, f));
  std::size_t last = h.size();
  while (last > 0 && h[last - 1] < kNothingLeft) --last;
  return last < h.size() ? std::min(top, f[last] * 1.06) : top;
}

SliceNodes Sensors::slice(std::size_t condition, double angle_rad, double reach_px) const {
  const System<double>& system = systems_[condition];
  const double scale = scale_of(system, angle_rad);
  std::vector<double> breaks;
  for (const Stage stage : mtf::kStages)
    for (const auto& entry : system.list(stage))
      for (const auto& context : contexts(system)) {
        const double cutoff = entry.component.cutoff_cy_mm(context);
        breaks.push_back(cutoff / scale);
        for (const double f : entry.component.breaks_cy_mm(context)) breaks.push_back(f / scale);
        if (!entry.component.is_pupil()) continue;
        // Where the rims of two annular pupils begin or cease to cross.
        if (const double e = obscuration_of(entry.component, context); e > 0.0)
          for (const double nu : {0.5 * (1.0 - e), e, 0.5 * (1.0 + e)}) breaks.push_back(nu * cutoff / scale);
      }
  constexpr double kLeastTop_cy_px = 1e-6;  // a sensor that passes nothing is no error here
  return slice_nodes(std::max(kLeastTop_cy_px, top_cy_px(condition, angle_rad)), reach_px, breaks);
}

}  // namespace calib
