// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/sensors.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "calib/fit/parameter_site.h"
#include "mtf/components/field_access.h"
#include "mtf/components/wavefront.h"
#include "mtf/otf/band_mean.h"
#include "mtf/otf/otf_series.h"

namespace calib {
namespace {

using mtf::Complex;
using mtf::Component;
using mtf::Freq;
using mtf::Stage;
using mtf::System;

constexpr std::size_t kStride = 4;
constexpr double kNothingLeft = 1e-8;
constexpr double kMostTop_cy_px = 32.0;

/// Numbers of a complex value for mtf::BandMean: real and imaginary part, then their derivatives.
template <class S>
constexpr std::size_t kNumbers = 2;
template <>
constexpr std::size_t kNumbers<Jet4> = 2 + 2 * kStride;

void pack(const Complex<double>& h, double* to) { to[0] = h.re, to[1] = h.im; }
void pack(const Complex<Jet4>& h, double* to) {
  to[0] = h.re.a, to[1] = h.im.a;
  for (std::size_t k = 0; k < kStride; ++k) {
    to[2 + k] = h.re.v[static_cast<Eigen::Index>(k)];
    to[2 + kStride + k] = h.im.v[static_cast<Eigen::Index>(k)];
  }
}
void unpack(const double* from, Complex<double>& h) { h = {from[0], from[1]}; }
void unpack(const double* from, Complex<Jet4>& h) {
  h.re.a = from[0], h.im.a = from[1];
  for (std::size_t k = 0; k < kStride; ++k) {
    h.re.v[static_cast<Eigen::Index>(k)] = from[2 + k];
    h.im.v[static_cast<Eigen::Index>(k)] = from[2 + kStride + k];
  }
}

double plain(double value) { return value; }
double largest_part(double value) { return std::abs(value); }
template <int N>
double plain(const ceres::Jet<double, N>& value) {
  return value.a;
}
template <int N>
double largest_part(const ceres::Jet<double, N>& value) {
  return std::max(std::abs(value.a), value.v.cwiseAbs().maxCoeff());
}

/// Frequencies as multiples of one vector of unit length, where that is what they are.
template <class S>
struct Ray {
  Freq<S> unit;
  std::vector<double> t;
};
template <class S>
double length(const Freq<S>& f) {
  return std::hypot(plain(f.x), plain(f.y));
}
template <class S>
Ray<S> unit_ray(const Freq<S>& f) {
  const double t = length(f);
  return t > 0.0 ? Ray<S>{{f.x / t, f.y / t}, {t}} : Ray<S>{{S(1), S(0)}, {0.0}};
}
template <class S>
std::optional<Ray<S>> common_ray(std::span<const Freq<S>> f) {
  constexpr double kSame = 1e-12;
  const auto longest = std::max_element(f.begin(), f.end(), [](auto& a, auto& b) { return length(a) < length(b); });
  Ray<S> ray{unit_ray(*longest).unit, {}};
  const double scale = kSame * std::max({largest_part(longest->x), largest_part(longest->y), 1e-300});
  for (const Freq<S>& one : f) {
    const double t = length(one);
    if (largest_part(one.x - ray.unit.x * t) > scale || largest_part(one.y - ray.unit.y * t) > scale)
      return std::nullopt;
    ray.t.push_back(t);
  }
  return ray;
}

/// Where the chromatic components of a list have their kinks, cycles/mm at the band's longest wavelength.
struct Kinks {
  std::vector<double> at;
  bool ends = false;  ///< nothing is left beyond the last
};

/// The mean of the product over the band, at frequencies of one ray from f = 0.
template <class S>
void mean_over_band(const System<S>& system, std::span<const Component<S>* const> chromatic, const Kinks& kinks,
                    const Ray<S>& ray, std::span<Complex<S>> h) {
  constexpr std::size_t width = kNumbers<S>, kFew = 8;
  std::vector<Freq<S>> f;
  std::vector<Complex<S>> node;
  const auto p = [&](double wavelength_um, std::span<const double> t, std::span<double> values) {
    f.clear();
    for (const double one : t) f.push_back({ray.unit.x * one, ray.unit.y * one});
    node.assign(t.size(), {S(1), S(0)});
    const mtf::Context<S> context = system.context(S(wavelength_um));
    for (const Component<S>* component : chromatic) component->multiply(f, context, node);
    for (std::size_t i = 0; i < t.size(); ++i) pack(node[i], &values[i * width]);
  };
  const double most = ray.t.size() > kFew ? *std::max_element(ray.t.begin(), ray.t.end()) : 0.0;
  const mtf::BandMean band(p, width, *system.band, kinks.at, kinks.ends, most);
  std::array<double, width> mean{};
  for (std::size_t i = 0; i < h.size(); ++i) {
    band.at(ray.t[i], mean);
    unpack(mean.data(), h[i]);
  }
}

/// h[i] *= an OTF that costs microseconds a frequency, along one ray up to its end: from its series between kinks.
/// `multiply(f, h)`: as of a component.
template <class S>
void multiply_by_series(const auto& multiply, double end, const std::vector<double>& kinks, const Ray<S>& ray,
                        std::span<Complex<S>> h) {
  constexpr double kError = 1e-7;  // of H, as of the mean over a band
  constexpr std::size_t kMostPanels = 64;
  std::vector<Freq<S>> f;
  const auto evaluate = [&](std::span<const double> t, mtf::SeriesValues<S, 1>& values) {
    f.clear();
    for (const double one : t) f.push_back({ray.unit.x * one, ray.unit.y * one});
    values[0].assign(t.size(), {S(1), S(0)});
    multiply(f, values[0]);
  };
  std::vector<mtf::SeriesPanel<S, 1>> panels;
  mtf::append_series<S, 1>(panels, {0.0, std::min(*std::ranges::max_element(ray.t), end)}, kError, kMostPanels, kinks,
                           evaluate);
  std::vector<bool> within(h.size());
  for (const mtf::SeriesPanel<S, 1>& panel : panels) {
    std::vector<std::size_t> here;
    std::vector<double> t;
    for (std::size_t i = 0; i < h.size(); ++i)
      if (!within[i] && ray.t[i] <= panel.map.hi) {
        within[i] = true;
        here.push_back(i);
        t.push_back(panel.map.t(ray.t[i]));
      }
    const mtf::ComplexValues<S> values = mtf::at_places(panel.otf[0], t);
    for (std::size_t k = 0; k < here.size(); ++k) h[here[k]] = h[here[k]] * values[k];
  }
  for (std::size_t i = 0; i < h.size(); ++i)
    if (!within[i]) h[i] = {S(0), S(0)};  // beyond the cutoff
}

constexpr std::size_t kFew = 32;  // frequencies that cost less than a series

/// The OTF of an entry of the presample list, where it is at hand.
template <class S>
struct GivenOtf {
  std::size_t entry = 0;
  std::vector<Complex<S>> h{};  ///< none: it is not
};

template <class S>
std::vector<Complex<S>> product(const System<S>& system, std::span<const Kinks> kinks, std::span<const Freq<S>> f,
                                const GivenOtf<S>& given = {}) {
  std::vector<Complex<S>> h(f.size(), {S(1), S(0)}), mean(f.size());
  const std::optional<Ray<S>> ray = f.empty() ? std::nullopt : common_ray(f);
  const mtf::Context<S> middle = system.context();
  for (std::size_t stage = 0; stage < mtf::kStages.size(); ++stage) {
    std::vector<const Component<S>*> chromatic;
    for (const auto& entry : system.list(mtf::kStages[stage]))
      if (!given.h.empty() && &entry == &system.list(Stage::presample)[given.entry])
        for (std::size_t i = 0; i < f.size(); ++i) h[i] = h[i] * given.h[i];
      else if (system.band && entry.component.traits(middle).chromatic)
        chromatic.push_back(&entry.component);
      else if (entry.component.is_slow() && ray && f.size() > kFew)
        multiply_by_series<S>([&](auto& at, auto& otf) { entry.component.multiply(at, middle, otf); },
                              entry.component.cutoff_cy_mm(middle), entry.component.kinks_cy_mm(middle), *ray, h);
      else
        entry.component.multiply(f, middle, h);
    if (chromatic.empty() || f.empty()) continue;
    if (ray) {
      mean_over_band<S>(system, chromatic, kinks[stage], *ray, mean);
    } else {
      for (std::size_t i = 0; i < f.size(); ++i)
        mean_over_band<S>(system, chromatic, kinks[stage], unit_ray(f[i]), {&mean[i], 1});
    }
    for (std::size_t i = 0; i < f.size(); ++i) h[i] = h[i] * mean[i];
  }
  return h;
}

// An aberrated pupil takes the same sums for its OTF and for all derivatives, whatever chunk of four parameters they
// are of: evaluated once, as a Jet of several chunks.

constexpr std::size_t kChunks = 4;
constexpr double kPupilError = 1e-9;  // of H: a hundredth of that of its series
using WideJet = ceres::Jet<double, static_cast<int>(kStride* kChunks)>;

void add_lanes(const Jet4& from, std::size_t chunk, WideJet& to) {
  to.v.segment<kStride>(static_cast<Eigen::Index>(kStride * chunk)) = from.v;
}
void add_lanes(const std::optional<Jet4>& from, std::size_t chunk, std::optional<WideJet>& to) {
  if (from) add_lanes(*from, chunk, *to);
}

/// Of the pupil `entry` in the systems of some chunks, at the frequencies f[chunk].
std::vector<GivenOtf<Jet4>> pupil_of_chunks(std::span<const System<Jet4>* const> systems, std::size_t entry,
                                            std::span<const std::vector<Freq<Jet4>>> f) {
  std::vector<GivenOtf<Jet4>> all(systems.size(), {entry, {}});
  const System<Jet4>& first = *systems.front();
  mtf::Wavefront<WideJet> pupil;
  const auto wide_fields = mtf::detail::field_refs<mtf::Wavefront<WideJet>, WideJet>(pupil);
  mtf::Context<WideJet> context{mtf::detail::cast_frame<WideJet>(first.frame),
                                mtf::detail::cast_optics<WideJet>(first.optics),
                                mtf::detail::cast_value<WideJet>(first.context().wavelength_um)};
  std::vector<Freq<WideJet>> at(f.front().size());
  for (std::size_t i = 0; i < at.size(); ++i) at[i] = {WideJet(f.front()[i].x.a), WideJet(f.front()[i].y.a)};
  for (std::size_t c = 0; c < systems.size(); ++c) {
    const mtf::Context<Jet4> own = systems[c]->context();
    const Component<Jet4>& component = systems[c]->list(Stage::presample)[entry].component;
    const std::vector<mtf::FieldRef<Jet4>> fields = component.fields();
    if (c == 0) mtf::detail::cast_fields<WideJet, Jet4>(fields, wide_fields);
    for (std::size_t k = 0; k < fields.size(); ++k) {
      const bool list = std::holds_alternative<mtf::Coefficients<Jet4>*>(fields[k].value);
      for (std::size_t e = 0; e == 0 || list; ++e) {
        const Jet4* const number = mtf::detail::number_of(fields[k], e);
        if (number == nullptr) break;
        add_lanes(*number, c, *mtf::detail::number_of(wide_fields[k], e));
      }
    }
    add_lanes(own.frame.focal_length_mm, c, context.frame.focal_length_mm);
    add_lanes(own.optics.f_number, c, context.optics.f_number);
    add_lanes(own.optics.aperture_mm, c, context.optics.aperture_mm);
    add_lanes(own.optics.obscuration, c, context.optics.obscuration);
    add_lanes(own.wavelength_um, c, context.wavelength_um);
    for (std::size_t i = 0; i < at.size(); ++i) add_lanes(f[c][i].x, c, at[i].x), add_lanes(f[c][i].y, c, at[i].y);
  }
  const std::optional<Ray<WideJet>> ray = at.size() > kFew ? common_ray<WideJet>(at) : std::nullopt;
  std::vector<Complex<WideJet>> h(at.size(), {WideJet(1.0), WideJet(0.0)});
  const auto multiply = [&](const std::vector<Freq<WideJet>>& some, std::vector<Complex<WideJet>>& otf) {
    for (std::size_t i = 0; i < some.size(); ++i) otf[i] = otf[i] * pupil.otf(some[i], context, kPupilError);
  };
  if (ray)
    multiply_by_series<WideJet>(multiply, pupil.cutoff_cy_mm(context), pupil.kinks_cy_mm(context), *ray, h);
  else
    multiply(at, h);
  for (std::size_t c = 0; c < all.size(); ++c)
    for (const Complex<WideJet>& wide : h) {
      const auto lane = static_cast<Eigen::Index>(kStride * c);
      Complex<Jet4>& narrow = all[c].h.emplace_back(Complex<Jet4>{Jet4(wide.re.a), Jet4(wide.im.a)});
      narrow.re.v = wide.re.v.segment<kStride>(lane), narrow.im.v = wide.im.v.segment<kStride>(lane);
    }
  return all;
}

/// The presample entry whose OTF chunks are to share, of systems at one wavelength.
std::optional<std::size_t> shared_pupil(const System<double>& system) {
  const auto& list = system.list(Stage::presample);
  const auto found = std::ranges::find_if(
      list, [](const auto& entry) { return entry.component.template get_if<mtf::Wavefront<double>>() != nullptr; });
  if (system.band || found == list.end()) return std::nullopt;
  return static_cast<std::size_t>(found - list.begin());
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

/// Of every stage.
std::vector<Kinks> kinks_of(const System<double>& system) {
  std::vector<Kinks> all(mtf::kStages.size());
  if (!system.band) return all;
  constexpr double kSame = 1e-9;
  const mtf::Context<double> longest = system.context(system.band->hi_um);
  for (std::size_t stage = 0; stage < all.size(); ++stage) {
    Kinks& kinks = all[stage];
    double end = INFINITY;
    for (const auto& entry : system.list(mtf::kStages[stage])) {
      if (!entry.component.traits(system.context()).chromatic) continue;
      const std::vector<double> own = entry.component.kinks_cy_mm(longest);
      kinks.at.insert(kinks.at.end(), own.begin(), own.end());
      end = std::min(end, entry.component.cutoff_cy_mm(longest));
    }
    kinks.ends = std::isfinite(end);
    std::erase_if(kinks.at, [end](double f) { return !(f > 0.0 && f <= end); });
    std::sort(kinks.at.begin(), kinks.at.end());
    // Twice the same, or within rounding of it, is one.
    const auto same = [](double a, double b) { return b - a < kSame * b; };
    kinks.at.erase(std::unique(kinks.at.begin(), kinks.at.end(), same), kinks.at.end());
    if (kinks.ends) kinks.at.back() = end;
  }
  return all;
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
    places_.push_back({c});
    auto& numbers = numbers_.emplace_back();
    for (const std::string& path : paths) numbers.push_back(parameter_site(systems_[c], path).numbers);
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

std::size_t Sensors::place(std::size_t condition, std::vector<Point> points) {
  const System<double>& system = systems_[condition];
  if (system.is_isoplanatic()) return condition;
  for (const Point& point : points) system.field_point(point.x, point.y);  // throws where it is not known
  places_.push_back({condition, std::move(points)});
  return places_.size() - 1;
}

std::optional<mtf::FieldPoint<double>> Sensors::field_point(std::size_t place) const {
  const auto& [condition, points] = places_[place];
  if (points.empty()) return std::nullopt;
  Point middle;
  for (const Point& point : points) middle = {middle.x + point.x, middle.y + point.y};
  const auto n = static_cast<double>(points.size());
  return systems_[condition].field_point(middle.x / n, middle.y / n);
}

bool Sensors::varies_over_field(std::size_t parameter) const {
  const System<double>& system = systems_.front();
  const auto varies = [&](const double* one, const mtf::FieldNumber<double>& number) {
    const auto& terms = number.coefficient;
    if (std::ranges::any_of(terms, [&](const double& term) { return &term == one; })) return true;
    if (!number.map && std::ranges::count(terms, 0.0) == std::ssize(terms)) return false;
    const auto fields = system.list(Stage::presample)[number.entry].component.fields();
    return mtf::detail::number_of(fields[number.field], number.element) == one;
  };
  return std::ranges::any_of(numbers_.front()[parameter], [&](const double* one) {
    return one == &system.field.axis_x_px || one == &system.field.axis_y_px ||
           std::ranges::any_of(system.field.numbers, [&](const auto& number) { return varies(one, number); });
  });
}

template <class S>
std::vector<System<S>> Sensors::seen_from(const Place& place, const System<S>& system) {
  if (place.points.empty()) return {system};
  std::vector<System<S>> all;
  for (const Point& point : place.points) all.push_back(system.at(system.field_point(point.x, point.y)));
  return all;
}

std::vector<System<double>> Sensors::seen_at(std::size_t place) const {
  return seen_from(places_[place], systems_[places_[place].condition]);
}

OtfTable Sensors::otf(std::size_t place, std::span<const PixelFreq> f, const mtf::Unit* unit) const {
  const std::size_t n = f.size();
  OtfTable table(count_ + 2, std::vector<Complex<double>>(n));
  const Place& here = places_[place];
  const std::vector<Seeded>& seeded = jets_[here.condition];
  const std::vector<Kinks> kinks = kinks_of(seen_at(place).front());
  const std::optional<std::size_t> pupil = seeded.size() > 1 ? shared_pupil(systems_[here.condition]) : std::nullopt;
  for (std::size_t begin = 0; begin < seeded.size(); begin += kChunks) {
    const std::size_t chunks = std::min(kChunks, seeded.size() - begin);
    std::vector<std::vector<System<Jet4>>> systems;  // of each chunk, from each point
    for (std::size_t c = 0; c < chunks; ++c) systems.push_back(seen_from(here, seeded[begin + c].system));
    const double share = 1.0 / static_cast<double>(systems.front().size());
    for (std::size_t point = 0; point < systems.front().size(); ++point) {
      std::vector<const System<Jet4>*> seen;
      std::vector<std::vector<Freq<Jet4>>> at(chunks);
      for (std::size_t c = 0; c < chunks; ++c) {
        seen.push_back(&systems[c][point]);
        at[c].push_back({Jet4(0.0), Jet4(0.0)});  // frequency 0
        const std::size_t lane = count_ - std::min(count_, (begin + c) * kStride);
        for (const PixelFreq& one : f) {
          Jet4 x(one.x), y(one.y);
          if (begin + c + 1 == seeded.size()) {
            x.v[static_cast<Eigen::Index>(lane)] = one.dx;
            y.v[static_cast<Eigen::Index>(lane)] = one.dy;
          }
          at[c].push_back(to_focal_plane(seen[c]->frame, x, y, unit));
        }
      }
      const std::vector<GivenOtf<Jet4>> given =
          pupil ? pupil_of_chunks(seen, *pupil, at) : std::vector<GivenOtf<Jet4>>(chunks);
      for (std::size_t c = 0; c < chunks; ++c) {
        const std::size_t first = (begin + c) * kStride, last = std::min(first + kStride, count_ + 1);
        const std::vector<Complex<Jet4>> h = product<Jet4>(*seen[c], kinks, at[c], given[c]);
        for (std::size_t i = 0; i < n; ++i) {
          const Jet4 re = share * (h[i + 1].re / h[0].re), im = share * (h[i + 1].im / h[0].re);
          const auto add = [](Complex<double>& sum, double a, double b) { sum = {sum.re + a, sum.im + b}; };
          if (first == 0) add(table[0][i], re.a, im.a);
          for (std::size_t k = first; k < last; ++k) {
            const auto lane = static_cast<Eigen::Index>(k - first);
            add(table[k + 1][i], re.v[lane], im.v[lane]);
          }
        }
      }
    }
  }
  return table;
}

double Sensors::response_at_zero(std::size_t place) const {
  const System<double> system = seen_at(place).front();
  const Freq<double> none{0.0, 0.0};
  return product<double>(system, kinks_of(system), {&none, 1}).front().re;
}

std::vector<double> Sensors::modulus(std::size_t place, std::span<const PixelFreq> f) const {
  std::vector<PixelFreq> with_zero{{}};
  with_zero.insert(with_zero.end(), f.begin(), f.end());
  const std::vector<System<double>> systems = seen_at(place);
  std::vector<Complex<double>> sum(f.size());
  for (const System<double>& system : systems) {
    const auto h = product<double>(system, kinks_of(system), to_focal_plane(system, with_zero));
    for (std::size_t i = 0; i < f.size(); ++i)
      sum[i] = sum[i] + Complex<double>{h[i + 1].re / h[0].re, h[i + 1].im / h[0].re};
  }
  std::vector<double> all;
  for (const auto& [re, im] : sum) all.push_back(std::hypot(re, im) / static_cast<double>(systems.size()));
  return all;
}

double Sensors::top_cy_px(std::size_t place, double angle_rad) const {
  const System<double> system = seen_at(place).front();
  double top = kMostTop_cy_px;
  for (const Stage stage : mtf::kStages)
    for (const auto& entry : system.list(stage)) {
      double cutoff = 0.0;  // of a chromatic one: that of the shortest wavelength
      for (const auto& context : contexts(system)) cutoff = std::max(cutoff, entry.component.cutoff_cy_mm(context));
      top = std::min(top, cutoff / scale_of(system, angle_rad));
    }
  // Where nothing cuts off, the product fades. Steps too small to fall between the zeros of one factor for long. A
  // pupil has its cutoff and is no more than 1 before; of other components at several wavelengths the largest counts.
  std::vector<double> f;
  for (double here = 0.25; here < top; here *= 1.06) f.push_back(here);
  if (f.empty()) return top;
  const std::vector<Freq<double>> at = to_focal_plane(system, along(angle_rad, f));
  std::vector<double> most(f.size());
  for (const auto& context : contexts(system)) {
    std::vector<Complex<double>> h(f.size(), {1.0 / std::abs(response_at_zero(place)), 0.0});
    for (const Stage stage : mtf::kStages)
      for (const auto& entry : system.list(stage))
        if (!entry.component.is_pupil()) entry.component.multiply(at, context, h);
    for (std::size_t i = 0; i < f.size(); ++i) most[i] = std::max(most[i], std::hypot(h[i].re, h[i].im));
  }
  std::size_t last = f.size();
  while (last > 0 && most[last - 1] < kNothingLeft) --last;
  return last < f.size() ? std::min(top, f[last] * 1.06) : top;
}

SliceNodes Sensors::slice(std::size_t place, double angle_rad, double range_px) const {
  const System<double> system = seen_at(place).front();
  const double scale = scale_of(system, angle_rad);
  std::vector<double> breaks;
  for (const Stage stage : mtf::kStages)
    for (const auto& entry : system.list(stage))
      for (const auto& context : contexts(system))
        for (const double f : entry.component.kinks_cy_mm(context)) breaks.push_back(f / scale);
  constexpr double kLeastTop_cy_px = 1e-6;  // a sensor that passes nothing is no error here
  return slice_nodes(std::max(kLeastTop_cy_px, top_cy_px(place, angle_rad)), range_px, breaks);
}

}  // namespace calib
