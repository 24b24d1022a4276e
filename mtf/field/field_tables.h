// SPDX-License-Identifier: Apache-2.0
#pragma once

// The part of a presample OTF that changes over the image, at places of it, as tables over radius and direction.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "mtf/error.h"
#include "mtf/field/field_modes.h"
#include "mtf/math/special.h"
#include "mtf/otf/polar_table.h"

namespace mtf::field {

using Entries = std::vector<Entry<double>>;

inline constexpr std::int64_t kMostValues = 10000;  // of an OTF that a table takes
inline constexpr int kMostBandNodes = 32;
inline constexpr double kMostInAll = 1.5e6;  // values of an OTF at one wavelength, for all places
inline constexpr double kRadiusShare = 2.0;  // of the error of a table, for interpolation along a radius
inline constexpr double kMostBytes = 2e9;    // of all tables

/// The components of a system that are the same all over the image, and the others.
struct Parts {
  std::vector<std::size_t> changing;  ///< of the presample list
  bool slow = false;                  ///< among these is one that costs microseconds a value
  bool chromatic = false;             ///< among these; all chromatic ones are
};

inline Parts parts_of(const System<double>& system) {
  const Entries& list = system.list(Stage::presample);
  const Context<double> ctx = system.context();
  std::vector<bool> changes(list.size());
  for (const FieldNumber<double>& number : system.field.numbers) changes.at(number.entry) = true;
  for (const FieldAngle& angle : system.field.angles) changes.at(angle.entry) = true;
  Parts parts;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Traits traits = list[i].component.traits(ctx);
    changes[i] = changes[i] || traits.placed;
    parts.chromatic = parts.chromatic || (changes[i] && system.band && traits.chromatic);
  }
  for (std::size_t i = 0; i < list.size(); ++i) parts.slow = parts.slow || (changes[i] && list[i].component.is_slow());
  for (std::size_t i = 0; i < list.size(); ++i)
    if (changes[i] || (parts.chromatic && list[i].component.traits(ctx).chromatic)) parts.changing.push_back(i);
  return parts;
}

/// The components that change, as they are at one place of the image.
class ChangingPart {
 public:
  ChangingPart(const System<double>& system, const Parts& parts, const FieldPoint<double>& q) : here_(system.at(q)) {
    for (const std::size_t i : parts.changing) entries_.push_back(here_.list(Stage::presample)[i]);
    if (parts.chromatic) {
      const WavelengthNodes nodes = wavelength_nodes(*here_.band, here_.band_nodes);
      for (std::size_t i = 0; i < nodes.weight.size(); ++i)
        wavelengths_.emplace_back(nodes.weight[i], here_.context(nodes.wavelength_um[i]));
    }
    real_ = even_x_ = even_y_ = true;
    for (const Entry<double>& entry : entries_) {
      const Traits traits = entry.component.traits(here_.context());
      real_ = real_ && traits.real;
      even_x_ = even_x_ && traits.even_x;
      even_y_ = even_y_ && traits.even_y;
      // The shortest wavelength reaches farthest.
      const Context<double> shortest = here_.band ? here_.context(here_.band->lo_um) : here_.context();
      cutoff_ = std::min(cutoff_, entry.component.cutoff_cy_mm(shortest));
      for (const Context<double>& ctx : ends())
        for (const double r : entry.component.kinks_cy_mm(ctx)) kinks_.push_back(r);
    }
  }

  Complex<double> otf(const Freq<double>& f) const {
    const auto product = [&](const Context<double>& ctx) {
      Complex<double> h{1.0, 0.0};
      for (const Entry<double>& entry : entries_) h = h * entry.component.otf(f, ctx);
      return h;
    };
    if (wavelengths_.empty()) return product(here_.context());
    Complex<double> mean{};
    for (const auto& [weight, ctx] : wavelengths_) mean = mean + Complex<double>{weight, 0.0} * product(ctx);
    return mean;
  }
  const std::vector<double>& kinks() const { return kinks_; }
  double cutoff() const { return cutoff_; }
  bool is_real() const { return real_; }
  bool is_even_x() const { return even_x_; }
  bool is_even_y() const { return even_y_; }

 private:
  std::vector<Context<double>> ends() const {
    if (!here_.band) return {here_.context()};
    return {here_.context(here_.band->lo_um), here_.context(here_.band->hi_um)};
  }

  System<double> here_;
  Entries entries_;
  std::vector<std::pair<double, Context<double>>> wavelengths_;  ///< weights and contexts of the band's average
  std::vector<double> kinks_;
  double cutoff_ = std::numeric_limits<double>::infinity();
  bool real_ = true, even_x_ = true, even_y_ = true;
};

/// Chebyshev points -1 .. 1 with both ends.
inline double point_at(std::size_t i, std::size_t n) {
  return -std::cos(kPi * static_cast<double>(i) / static_cast<double>(n - 1));
}

/// Weights of the values at those points for the polynomial through them at t (barycentric form).
inline std::vector<double> lagrange(std::size_t n, double t) {
  std::vector<double> weight(n);
  double sum = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const double distance = t - point_at(i, n);
    if (distance == 0.0) {
      std::fill(weight.begin(), weight.end(), 0.0);
      weight[i] = 1.0;
      return weight;
    }
    weight[i] = (i % 2 == 0 ? 1.0 : -1.0) * (i == 0 || i == n - 1 ? 0.5 : 1.0) / distance;
    sum += weight[i];
  }
  for (double& w : weight) w /= sum;
  return weight;
}

/// By how much interpolation between n such points may enlarge an error of the values.
inline double lebesgue(std::size_t n) { return 1.0 + 2.0 / kPi * std::log(static_cast<double>(n)); }

/// Wavelengths for the product of the components that change, from values at the axis and at corners.
struct BandNodes {
  int count = 0;
  double error = 0.0;  ///< the last change
};
inline BandNodes band_nodes_for(const System<double>& system, const Parts& parts,
                                std::span<const FieldPoint<double>> places, double end, double target) {
  constexpr int kRadii = 8;
  if (!parts.chromatic) return {system.band_nodes, 0.0};
  const auto values = [&](int nodes) {
    System<double> with = system;
    with.band_nodes = nodes;
    std::vector<Complex<double>> h;
    for (const FieldPoint<double>& q : places) {
      const ChangingPart here(with, parts, q);
      for (int i = 0; i < kRadii; ++i)
        for (const double a : {0.1, 0.35, 0.6, 0.85}) {
          const double r = std::min(end, here.cutoff()) * (i + 0.5) / kRadii;
          h.push_back(here.otf({r * cos_pi(a), r * sin_pi(a)}));
        }
    }
    return h;
  };
  BandNodes nodes{4, 0.0};
  std::vector<Complex<double>> coarse = values(nodes.count);
  while (nodes.count < kMostBandNodes) {
    const std::vector<Complex<double>> fine = values(2 * nodes.count);
    nodes = {2 * nodes.count, 0.0};
    for (std::size_t i = 0; i < fine.size(); ++i)
      nodes.error = std::max(nodes.error, std::hypot(fine[i].re - coarse[i].re, fine[i].im - coarse[i].im));
    if (nodes.error <= target) break;
    coarse = fine;
  }
  return nodes;
}

/// Makes the tables of the components that change, as they are at places of the image, with the same breaks.
struct TableMaker {
  const System<double>& system;
  const Parts& parts;
  const std::vector<double>& breaks;
  double end = 0.0;
  std::int64_t most = kMostValues;  ///< that one table takes
  const FieldModesOptions& options;

  PolarTable table_of(const ChangingPart& place) const {
    const PolarTable::Function h = [&place](const Freq<double>& f) { return place.otf(f); };
    PolarTable table(h, PolarTable::rings_of(h, options.threads), breaks, options.table_error, most, options.threads);
    if (options.progress) options.progress(table.evaluations());
    return table;
  }

  struct Tables {
    std::vector<PolarTable> at;
    double error = 0.0;
    double values = 0.0;  ///< that they took for each place; 0 where more places take no more
  };
  Tables all(std::span<const FieldPoint<double>> places, std::span<const ChangingPart> here) const {
    Tables tables = by_radius(places);
    if (!tables.at.empty()) return tables;
    for (const ChangingPart& place : here) {
      tables.at.push_back(table_of(place));
      tables.error = std::max(tables.error, tables.at.back().error());
      tables.values += static_cast<double>(tables.at.back().evaluations()) / static_cast<double>(here.size());
      const double bytes = static_cast<double>(tables.at.back().bytes()) * static_cast<double>(here.size());
      if (bytes > kMostBytes)
        throw UsageError("the OTFs at " + std::to_string(here.size()) + " places of the image would take " +
                         format_double(bytes) + " bytes; give terms by which the cutoff of the optics changes less");
    }
    return tables;
  }

 private:
  /// Of a system whose OTF turns with the direction of the field point and depends on its distance besides: a few
  /// tables along a radius serve all places. Empty for another system, or where the radius takes too many.
  Tables by_radius(std::span<const FieldPoint<double>> places) const {
    constexpr std::array<std::size_t, 2> kRadii{9, 17};
    double farthest = 0.0;
    for (const FieldPoint<double>& q : places) farthest = std::max(farthest, std::hypot(q.x, q.y));
    if (farthest == 0.0 || !turns(farthest)) return {};
    for (const std::size_t n : kRadii) {
      std::vector<PolarTable> along;
      for (std::size_t i = 0; i < n; ++i)
        along.push_back(table_of(ChangingPart(system, parts, {0.5 * farthest * (1.0 + point_at(i, n)), 0.0})));
      std::vector<const PolarTable*> pointers;
      for (const PolarTable& table : along) pointers.push_back(&table);
      const auto at = [&](double r) {
        return PolarTable::combination(pointers, lagrange(n, std::clamp(2.0 * r / farthest - 1.0, -1.0, 1.0)));
      };
      double worst = 0.0;
      for (const double share : {0.03, 0.37, 0.71, 0.97}) {
        const ChangingPart exact(system, parts, {share * farthest, 0.0});
        const PolarTable table = at(share * farthest);
        for (const Freq<double>& f : some_frequencies()) {
          const Complex<double> h = exact.otf(f), t = table.at(f);
          worst = std::max(worst, std::hypot(h.re - t.re, h.im - t.im));
        }
      }
      if (worst > kRadiusShare * options.table_error) continue;
      Tables tables{{}, worst};
      for (const PolarTable& table : along) tables.error = std::max(tables.error, worst + lebesgue(n) * table.error());
      for (const FieldPoint<double>& q : places)
        tables.at.push_back(at(std::hypot(q.x, q.y)).turned(std::atan2(q.y, q.x)));
      return tables;
    }
    return {};
  }

  std::vector<Freq<double>> some_frequencies() const {
    std::vector<Freq<double>> f;
    for (int i = 0; i < 16; ++i) {
      const double r = end * (i + 0.5) / 16.0, a = 0.618 * i;
      f.push_back({r * cos_pi(a), r * sin_pi(a)});
    }
    return f;
  }
  bool turns(double farthest) const {
    for (const double r : {0.4 * farthest, farthest}) {
      const ChangingPart on_x(system, parts, {r, 0.0});
      for (const double angle : {0.3, 1.5707963267948966, 2.5, -2.0}) {
        const double c = std::cos(angle), s = std::sin(angle);
        const ChangingPart turned(system, parts, {r * c, r * s});
        for (const Freq<double>& f : some_frequencies()) {
          const Complex<double> a = on_x.otf(f), b = turned.otf({c * f.x - s * f.y, s * f.x + c * f.y});
          if (std::hypot(a.re - b.re, a.im - b.im) > 0.1 * options.table_error) return false;
        }
      }
    }
    return true;
  }
};

}  // namespace mtf::field
