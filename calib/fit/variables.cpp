// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/variables.h"

#include <algorithm>
#include <cmath>

#include "mtf/error.h"
#include "mtf/parallel.h"

namespace calib {
namespace {

/// Narrower, of the value itself, a prior is beyond what arithmetic resolves beside the data.
constexpr double kLeastPrior = 1e-9;
/// Directions are unbounded; a first step may be many turns.
constexpr double kFarRound_deg = 1e6 + 77.0;
constexpr double kSmallestSquare = 1e-8;  // the value is 1e-4 steps there, and its slope still exact

/// H of all probes, and its derivatives by parameter i, real and imaginary parts in one list.
struct Response {
  std::vector<double> h, slope;
};

Response response(const Sensors& sensors, std::span<const Probe> probes, std::size_t i, int threads) {
  std::vector<OtfTable> tables(probes.size());
  mtf::parallel_for(std::ssize(probes), 1, threads, [&](std::int64_t first, std::int64_t last) {
    for (auto p = static_cast<std::size_t>(first); p < static_cast<std::size_t>(last); ++p)
      tables[p] = sensors.otf(probes[p].place, probes[p].f, probes[p].unit);
  });
  Response all;
  for (std::size_t p = 0; p < probes.size(); ++p) {
    const OtfTable& table = tables[p];
    for (std::size_t k = 0; k < probes[p].f.size(); ++k)
      for (const auto part : {&mtf::Complex<double>::re, &mtf::Complex<double>::im}) {
        all.h.push_back(table[0][k].*part);
        all.slope.push_back(table[i + 1][k].*part);
      }
  }
  return all;
}

double largest(const std::vector<double>& a) {
  double most = 0.0;
  for (const double v : a) most = std::max(most, std::abs(v));
  return most;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b, double factor = 1.0) {
  double most = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) most = std::max(most, std::abs(a[k] - factor * b[k]));
  return most;
}

struct Prober {
  Sensors& sensors;
  std::span<const Probe> probes;
  std::span<const double> start;
  int threads = 0;

  Response at(std::size_t i, double value) const {
    std::vector<double> values(start.begin(), start.end());
    values[i] = value;
    sensors.set(values);
    return response(sensors, probes, i, threads);
  }
};

/// The starting values, those of signed parameters that would do nothing there moved to where they act: beside a
/// spherical aberration of 0 a defocus acts by its square, beside another it does not.
std::vector<double> acting_values(const Prober& prober, std::span<const mtf::FieldInfo> infos) {
  constexpr double kSeen = 0.02, kNothing = 1e-3;
  std::vector<double> values(prober.start.begin(), prober.start.end());
  if (infos.size() < 2) return values;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(infos[i].lo < 0.0 && infos[i].hi > 0.0)) continue;
    const Response none = prober.at(i, 0.0);
    const auto effect = [&](double value) { return largest_difference(prober.at(i, value).h, none.h); };
    if (effect(values[i]) > kNothing) continue;
    double value = std::max(std::abs(values[i]), 1e-6);
    while (4.0 * value < infos[i].hi && effect(value) < kSeen) value *= 4.0;
    values[i] = value;
  }
  return values;
}

/// A value of parameter i at which an even effect is small and yet well above rounding; 0 when there is none, or when
/// the effect is not that of a square.
double square_at(const Prober& prober, std::size_t i, const mtf::FieldInfo& info) {
  const double most = std::min(info.hi, 1e6 * std::max(1.0, std::abs(prober.start[i])));
  const Response none = prober.at(i, 0.0);
  if (largest(none.slope) > 1e-6 / std::max(1e-300, most) && largest(none.slope) * most > 1e-3) return 0.0;
  for (double t = 1e-6 * std::max(1e-3, std::abs(prober.start[i])); 2.0 * t <= most; t *= 4.0) {
    const Response once = prober.at(i, t);
    const double effect = largest_difference(once.h, none.h);
    if (effect < 1e-6) continue;
    const Response twice = prober.at(i, 2.0 * t);
    if (largest_difference(twice.slope, once.slope, 2.0) > 0.05 * largest(twice.slope)) return 0.0;
    if (info.lo < 0.0 && largest_difference(prober.at(i, -t).h, once.h) > 1e-3 * effect) return 0.0;
    return t;
  }
  return 0.0;
}

/// In degrees, over whole turns.
bool is_direction(const mtf::FieldInfo& info) { return info.unit == "deg" && info.lo <= -360.0 && info.hi >= 360.0; }

[[noreturn]] void refuse(const FitParameter& parameter, const std::string& why) {
  throw mtf::UsageError(parameter.path + ": " + why);
}

void check_numbers(const FitParameter& p, const mtf::FieldInfo& info, double start) {
  for (const double number : {start, p.min.value_or(0.0), p.max.value_or(0.0), p.prior ? (*p.prior)[0] : 0.0})
    if (!std::isfinite(number)) refuse(p, "value, bounds and prior have to be finite");
  if (p.prior && !((*p.prior)[1] > 0.0 && std::isfinite((*p.prior)[1]))) refuse(p, "the sd of a prior is above 0");
  if (p.prior && !((*p.prior)[1] > kLeastPrior * std::max(std::abs((*p.prior)[0]), std::abs(start))))
    refuse(p, "a prior this narrow leaves nothing to fit; give the number as fixed");
  const double lo = std::max(info.lo, p.min.value_or(info.lo)), hi = std::min(info.hi, p.max.value_or(info.hi));
  if (p.prior && !((*p.prior)[0] >= info.lo && (*p.prior)[0] <= info.hi))
    refuse(p, "the mean of the prior is outside of what the field allows, " + mtf::format_double(info.lo) + " to " +
                  mtf::format_double(info.hi));
  if (!(lo < hi))
    refuse(p, "nothing is left between the bounds " + mtf::format_double(lo) + " and " + mtf::format_double(hi) +
                  "; the field itself allows " + mtf::format_double(info.lo) + " to " + mtf::format_double(info.hi));
}

}  // namespace

double Variable::value(double x) const {
  if (squared) return sign * step * std::sqrt(std::max(x, kSmallestSquare));
  return period > 0.0 ? step * x - period * std::round(step * x / period) : step * x;
}
double Variable::slope(double x) const {
  return squared ? 0.5 * sign * step / std::sqrt(std::max(x, kSmallestSquare)) : step;
}
double Variable::x_of(double value) const {
  const double x = value / step;
  return squared ? x * x : x;
}

std::vector<Variable> make_variables(Sensors& sensors, std::span<const FitParameter> parameters,
                                     std::span<const double> start, std::span<const mtf::FieldInfo> infos,
                                     std::span<const Probe> probes, int threads) {
  const Prober prober{sensors, probes, start, threads};
  for (std::size_t i = 0; i < parameters.size(); ++i) check_numbers(parameters[i], infos[i], start[i]);
  const std::vector<double> acting = acting_values(prober, infos);
  std::vector<Variable> all;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const mtf::FieldInfo& info = infos[i];
    // Open ends of a range are not allowed themselves.
    const double inside = 1e-9 * std::max(1.0, std::abs(start[i]));
    const double field_lo = info.lo_open ? info.lo + inside : info.lo,
                 field_hi = info.hi_open ? info.hi - inside : info.hi;
    const double lo = std::max(field_lo, parameters[i].min.value_or(field_lo));
    const double hi = std::min(field_hi, parameters[i].max.value_or(field_hi));
    const double value = std::clamp(start[i], lo, hi);

    Variable v;
    v.positive = info.lo >= 0.0;
    const bool reaches_zero = info.lo <= 0.0 && !info.lo_open && info.hi > 0.0;
    const bool signs_differ = lo < 0.0 && hi > 0.0 && parameters[i].prior && (*parameters[i].prior)[0] != 0.0;
    v.direction = is_direction(info);
    const bool may_be_square = reaches_zero && !signs_differ && !v.direction;
    const double small = may_be_square ? square_at({sensors, probes, acting, threads}, i, info) : 0.0;
    v.squared = small > 0.0 && (info.lo >= 0.0 || (lo <= 0.0 && hi >= 0.0) || lo > 0.0);
    if (v.squared) {
      v.sign = -lo > hi || (-lo == hi && value < 0.0) ? -1.0 : 1.0;
      v.other_side = std::max(0.0, std::min(-lo, hi));
      v.positive = true;
      // By the square: dH/d(value^2) = dH/dvalue / (2 value). A large start may have left the range of its effect.
      const double here = std::max(std::abs(value), small);
      const double slope = std::max(largest(prober.at(i, v.sign * here).slope) / (2.0 * here),
                                    1e-3 * largest(prober.at(i, v.sign * small).slope) / (2.0 * small));
      v.step = std::sqrt(kUnitEffect / slope);
      const double near = v.sign > 0.0 ? std::max(0.0, lo) : std::max(0.0, -hi);
      v.lo = v.x_of(near);
      v.hi = v.x_of(v.sign > 0.0 ? hi : lo);
    } else {
      const double slope = largest(prober.at(i, value).slope);
      v.step = slope > 0.0 && std::isfinite(1.0 / slope) ? kUnitEffect / slope : std::max(1.0, std::abs(value));
      v.step = std::min(v.step, 1e3 * std::max(1.0, std::abs(value)));
      v.lo = lo / v.step;
      v.hi = hi / v.step;
      if (v.direction && !parameters[i].min && !parameters[i].max && !parameters[i].prior) {
        const Response here = prober.at(i, 0.0), across = prober.at(i, 90.0), turned = prober.at(i, 180.0);
        const bool seen = largest_difference(here.h, across.h) > 1e-6;
        v.period = seen && largest_difference(here.h, turned.h) < 1e-9 ? 180.0 : 360.0;
        v.hi = kFarRound_deg / v.step;
        v.lo = -v.hi;
      }
    }
    v.start = std::clamp(v.x_of(value), v.lo, v.hi);
    all.push_back(v);
  }
  std::vector<double> x;
  for (const Variable& v : all) x.push_back(v.start);
  sensors.set(values_at(all, x));
  return all;
}

std::vector<double> seen_values(Sensors& sensors, std::span<const Variable> variables, std::span<const double> start,
                                std::span<const Probe> probes, int threads) {
  constexpr double kUnseen = 0.1;  // of a unit effect, for a change by the parameter's own size
  constexpr double kBlurred = 0.02, kLeast = 1e-12;
  const Prober prober{sensors, probes, start, threads};
  std::vector<double> values(start.begin(), start.end());
  for (std::size_t i = 0; i < variables.size(); ++i) {
    const Variable& v = variables[i];
    const auto effect = [&](const Response& at, double value) { return value * largest(at.slope) / kUnitEffect; };
    if (v.squared || !v.positive) continue;
    // Where no contrast is left the start is wrong in another respect, which the fit reports.
    if (const Response here = prober.at(i, start[i]); !(effect(here, start[i]) < kUnseen && largest(here.h) > kBlurred))
      continue;
    const double least = std::max(v.value(v.lo), kLeast * start[i]);
    for (double value = 0.25 * start[i]; value > least && values[i] == start[i]; value *= 0.25)
      if (effect(prober.at(i, value), value) >= 1.0) values[i] = value;
  }
  return values;
}

std::vector<double> values_at(std::span<const Variable> variables, std::span<const double> x) {
  std::vector<double> values;
  for (std::size_t i = 0; i < variables.size(); ++i) values.push_back(variables[i].value(x[i]));
  return values;
}

}  // namespace calib
