// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bodies of spectral_path.h and range_table.h for any scalar. Every optical depth is a sum of spectra times amounts (of
// lines: C^a times W^a), so that one exponential a wavenumber and layer is all that is left.

#include "mtf/units.h"
#include "radiometry/atmosphere/amounts_impl.h"
#include "radiometry/atmosphere/range_table.h"

namespace radiometry::atmosphere {

/// Indices of the grid.
struct Slice {
  std::size_t first = 0, count = 0;
  std::size_t emitting() const {
    return first >= kEmissionWavenumbers ? 0 : std::min(count, kEmissionWavenumbers - first);
  }
};
Slice slice_of(const Interval& band);
void require_options(const SpectralOptions& options);

/// W m^-2 sr^-1 per cm^-1 and its slope by the temperature.
mtf::ValueSlope planck_per_cm(double wavenumber_cm, double temperature_k);

/// A path by rising wavelength, radiance per um.
struct WavelengthCurves {
  std::vector<double> wavelength_um, transmission, radiance;
};
WavelengthCurves curves_of(const SpectralPath<double>& path);

/// Which components are computed.
using Kept = std::array<bool, kComponents>;
inline constexpr Kept kAllComponents = [] {
  Kept kept{};
  kept.fill(true);
  return kept;
}();

/// W^a of each band. Slopes are those of no less than `least`, as they are infinite at 0.
template <class S>
std::array<S, kLineBands> line_strengths(const Amounts<S>& amounts, const std::array<double, kLineBands>& least) {
  std::array<S, kLineBands> out;
  const auto laws = band_laws();
  for (std::size_t i = 0; i < kLineBands; ++i) {
    const double w = value_of(amounts.lines[i]), from = std::max(w, least[i]), a = laws[i].a;
    out[i] = from > 0.0 ? lift({std::pow(w, a), a * std::pow(from, a - 1.0)}, amounts.lines[i]) : S(0.0);
  }
  return out;
}

template <class S>
void add(const Coefficients& k, const S& amount, Slice slice, std::vector<S>& depth) {
  if (value_of(amount) == 0.0 && !requires(S s) { s.a; }) return;
  const std::size_t from = std::max(k.first, slice.first),
                    to = std::min(k.first + k.value.size(), slice.first + slice.count);
  if (from >= to) return;
  const double* value = k.value.data() + (from - k.first);
  S* out = depth.data() + (from - slice.first);
  for (std::size_t i = 0; i < to - from; ++i) out[i] += value[i] * amount;
}

/// Adds the optical depth of one component.
template <class S>
void add_component(Component component, const Amounts<S>& amounts, const std::array<S, kLineBands>& strengths,
                   Slice slice, std::vector<S>& depth) {
  const BandModel& model = band_model();
  const auto laws = band_laws();
  for (std::size_t i = 0; i < kLineBands; ++i)
    if (component_of(laws[i].gas) == component)
      for (const Coefficients& run : model.lines[i]) add(run, strengths[i], slice, depth);
  switch (component) {
    case Component::water_continuum:
      add(model.water_foreign, amounts.water_foreign, slice, depth);
      add(model.water_self_296, amounts.water_self_296, slice, depth);
      add(model.water_self_260, amounts.water_self_260, slice, depth);
      break;
    case Component::oxygen:
      for (std::size_t i = 0; i < 3; ++i) add(model.oxygen[i], amounts.oxygen[i], slice, depth);
      break;
    case Component::nitrogen:
      add(model.nitrogen, amounts.nitrogen, slice, depth);
      break;
    case Component::molecular:
      add({0, model.molecules}, amounts.molecules, slice, depth);
      break;
    case Component::aerosol:
      if (value_of(amounts.aerosol.front()) != 0.0 || requires(S s) { s.a; })
        for (std::size_t i = 0; i < slice.count; ++i) {
          const auto node = static_cast<std::size_t>(model.aerosol_node[slice.first + i]);
          const double share = model.aerosol_share[slice.first + i];
          depth[i] += (1.0 - share) * amounts.aerosol[node] + share * amounts.aerosol[node + 1];
        }
      break;
    case Component::rain:
      for (std::size_t i = 0; i < slice.count; ++i) depth[i] += amounts.rain;
      break;
    default:
      break;
  }
}

template <class S>
void to_transmission(std::vector<S>& depth) {
  using std::exp;
  for (S& d : depth) d = exp(-d);
}

/// The state of a line at some length from the sensor.
template <class S>
struct Along {
  Amounts<S> amounts;
  std::vector<S> transmission, radiance;
};

template <class S>
class SpectralLine {
 public:
  SpectralLine(const Line<S>& line, const SpectralOptions& options)
      : line_(line),
        options_(options),
        slice_(slice_of(options.band)),
        layers_of_line_(line),
        layers_(layers_of_line_.layers) {
    if (value_of(line.numbers.range_m) < 1.0)
      for (std::size_t i = 0; i < kLineBands; ++i) least_[i] = 1e-3 * value_of(line.at_sensor[i]);
    leave_out();
  }

  /// Spectral paths of rising ranges, all within the line.
  std::vector<SpectralPath<S>> at(const std::vector<S>& ranges_m) const {
    std::vector<SpectralPath<S>> out;
    Along<S> state{{}, std::vector<S>(slice_.count, S(1.0)), std::vector<S>(slice_.emitting(), S(0.0))};
    S length(0.0);
    std::size_t next = 0;
    for (std::size_t i = 0; i < layers_.size() && next < ranges_m.size(); ++i) {
      const S end = length + layers_[i].length_m;
      const bool last = i + 1 == layers_.size();
      while (next < ranges_m.size() && value_of(ranges_m[next]) < value_of(end)) {
        const S rest = ranges_m[next] - length;
        out.push_back(
            result(advanced(state, layers_of_line_.part(i, cut_piece(line_.pieces[i], rest)), i), ranges_m[next]));
        ++next;
      }
      if (next == ranges_m.size()) break;
      state = advanced(state, layers_[i], i);
      length = end;
      if (last) break;
    }
    for (; next < ranges_m.size(); ++next) out.push_back(result(state, ranges_m[next]));
    return out;
  }

  /// The whole line, by the numbers that it was given by.
  SpectralPath<S> whole() const {
    Along<S> state{{}, std::vector<S>(slice_.count, S(1.0)), std::vector<S>(slice_.emitting(), S(0.0))};
    for (std::size_t i = 0; i < layers_.size(); ++i) state = advanced(state, layers_[i], i);
    SpectralPath<S> path = result(state, line_.numbers.range_m);
    path.sight = line_.numbers;
    return path;
  }

 private:
  Piece<S> cut_piece(const Piece<S>& piece, const S& length_m) const {
    if (!line_.horizontal) return cut(piece, length_m);
    Piece<S> out = piece;
    out.length_m = length_m;
    return out;
  }

  std::vector<S> depth_of(const Amounts<S>& amounts) const {
    std::vector<S> depth(slice_.count, S(0.0));
    const auto strengths = line_strengths(amounts, least_);
    for (std::size_t c = 0; c < kComponents; ++c)
      if (kept_[c]) add_component(static_cast<Component>(c), amounts, strengths, slice_, depth);
    return depth;
  }

  Along<S> advanced(const Along<S>& state, const PathLayer<S>& layer, std::size_t index) const {
    if (index >= kept_layers_) return state;
    Along<S> out{sum_of(state.amounts, layer.amounts), {}, state.radiance};
    out.transmission = depth_of(out.amounts);
    to_transmission(out.transmission);
    for (std::size_t i = 0; i < out.radiance.size(); ++i) {
      const auto planck = planck_per_cm(wavenumber_cm(slice_.first + i), value_of(layer.temperature_k));
      out.radiance[i] += lift(planck, layer.temperature_k) * (state.transmission[i] - out.transmission[i]);
    }
    return out;
  }

  SpectralPath<S> result(const Along<S>& state, const S& range_m) const {
    SpectralPath<S> path;
    for (std::size_t i = 0; i < slice_.count; ++i) path.wavenumber_cm.push_back(wavenumber_cm(slice_.first + i));
    path.transmission = state.transmission;
    path.radiance = state.radiance;
    path.sight = line_.numbers;
    path.sight.range_m = range_m;
    path.left_out = left_out_;
    if (options_.components) {
      const auto strengths = line_strengths(state.amounts, least_);
      for (std::size_t c = 0; c < kComponents; ++c) {
        path.component[c].assign(slice_.count, S(0.0));
        if (kept_[c]) add_component(static_cast<Component>(c), state.amounts, strengths, slice_, path.component[c]);
        to_transmission(path.component[c]);
      }
    }
    return path;
  }

  /// Half of the tolerance for components, half for layers at the end of the line.
  void leave_out() {
    kept_layers_ = layers_.size();
    if (!(options_.tolerance > 0.0)) return;
    Amounts<S> whole;
    for (const PathLayer<S>& layer : layers_) whole = sum_of(whole, layer.amounts);
    std::vector<std::pair<double, std::size_t>> bounds;
    const auto strengths = line_strengths(whole, least_);
    for (std::size_t c = 0; c < kComponents; ++c) {
      std::vector<S> depth(slice_.count, S(0.0));
      add_component(static_cast<Component>(c), whole, strengths, slice_, depth);
      double most = 0.0;
      for (const S& d : depth) most = std::max(most, value_of(d));
      if (most > 0.0) bounds.emplace_back(-std::expm1(-most), c);
    }
    std::ranges::sort(bounds);
    double sum = 0.0;
    for (const auto& [bound, c] : bounds) {
      sum += bound;
      if (sum > 0.5 * options_.tolerance) break;
      kept_[c] = false;
      left_out_.push_back({std::string(kComponentNames[c]), bound});
    }
    leave_out_layers(whole);
  }

  void leave_out_layers(const Amounts<S>& whole) {
    std::vector<S> depth = depth_of(whole);
    to_transmission(depth);
    std::vector<Amounts<S>> sums{Amounts<S>{}};
    for (const PathLayer<S>& layer : layers_) sums.push_back(sum_of(sums.back(), layer.amounts));
    const auto change = [&](std::size_t layers) {
      std::vector<S> part = depth_of(sums[layers]);
      to_transmission(part);
      double most = 0.0;
      for (std::size_t i = 0; i < part.size(); ++i) most = std::max(most, value_of(part[i]) - value_of(depth[i]));
      return most;
    };
    std::size_t lo = 0, hi = layers_.size();  // hi layers are enough
    while (hi - lo > 1) {
      const std::size_t middle = (lo + hi) / 2;
      (change(middle) <= 0.5 * options_.tolerance ? hi : lo) = middle;
    }
    if (hi == layers_.size()) return;
    kept_layers_ = hi;
    left_out_.push_back({"layers from " + mtf::format_double(std::round(value_of(line_.pieces[hi].from_m))) +
                             " m on, at the end of the line",
                         change(hi)});
  }

  const Line<S>& line_;
  SpectralOptions options_;
  Slice slice_;
  LineLayers<S> layers_of_line_;
  const std::vector<PathLayer<S>>& layers_;
  std::array<double, kLineBands> least_{};
  Kept kept_ = kAllComponents;
  std::size_t kept_layers_ = 0;
  std::vector<LeftOut> left_out_;
};

template <class S>
SpectralPath<S> spectral_path(const Air<S>& air, const Sight<S>& sight, const SpectralOptions& options) {
  require_options(options);
  const Line<S> line = line_of(air, sight);
  return SpectralLine<S>(line, options).whole();
}

void require_ranges(std::span<const double> ranges_m);
[[noreturn]] void refuse_beyond(double range_m, double end_m);

template <class S>
Sight<S> with_range(Sight<S> sight, double range_m) {
  std::visit(
      [&](auto& one) {
        if constexpr (requires { one.range_m; }) one.range_m = S(range_m);
      },
      sight);
  return sight;
}

template <class S>
std::vector<SpectralPath<S>> spectral_paths(const Air<S>& air, const Sight<S>& sight, std::span<const double> ranges_m,
                                            const SpectralOptions& options) {
  require_options(options);
  require_ranges(ranges_m);
  std::vector<SpectralPath<S>> paths;
  if (std::holds_alternative<Between<S>>(sight)) {
    for (const double range : ranges_m) paths.push_back(spectral_path(air, with_range(sight, range), options));
    return paths;
  }
  const Line<S> line = line_of(air, with_range(sight, ranges_m.back()));
  const double end = value_of(line.numbers.range_m);
  if (ranges_m.back() > end * (1.0 + 1e-12)) refuse_beyond(ranges_m.back(), end);
  std::vector<S> ranges;
  for (const double range : ranges_m) ranges.push_back(S(range));
  paths = SpectralLine<S>(line, options).at(ranges);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    SightNumbers<S>& numbers = paths[i].sight;
    if (line.pieces.empty()) break;
    numbers.object_altitude_m = numbers.lowest_altitude_m = line.pieces.front().from_m;
    double rest = ranges_m[i];
    for (const Piece<S>& piece : line.pieces) {
      if (line.horizontal || rest <= 0.0) break;
      numbers.object_altitude_m = rest < value_of(piece.length_m) ? altitude_along(piece, S(rest)) : piece.to_m;
      if (value_of(numbers.object_altitude_m) < value_of(numbers.lowest_altitude_m))
        numbers.lowest_altitude_m = numbers.object_altitude_m;
      rest -= value_of(piece.length_m);
    }
    const Piece<S>& back = line.pieces.back();
    if (!line.horizontal && rest > 0.0)
      numbers.object_altitude_m = altitude_along(back, S(back.length_m + rest));  // in space
  }
  return paths;
}

}  // namespace radiometry::atmosphere
