// SPDX-License-Identifier: Apache-2.0
#include "calib/fit/fit_build.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "calib/fit/parameter_site.h"
#include "mtf/error.h"
#include "mtf/field/sample_ranges.h"

namespace calib {
namespace {

using mtf::System;
using mtf::UsageError;

constexpr std::size_t kMostParameters = 64;
constexpr std::size_t kMostProbes = 16;

/// "presample[0].f_number" that the file leaves to [optics].
bool falls_back(const System<double>& system, const std::string& path) {
  for (const mtf::Stage stage : mtf::kStages)
    for (std::size_t i = 0; i < system.list(stage).size(); ++i)
      for (const auto& field : system.list(stage)[i].component.fields()) {
        const auto* own = std::get_if<std::optional<double>*>(&field.value);
        if (own == nullptr || field.info->presence != mtf::Presence::shared || (*own)->has_value()) continue;
        const std::string here = std::string(mtf::stage_name(stage)) + "[" + std::to_string(i) + "].";
        if (path == here + std::string(field.info->name)) return true;
      }
  return false;
}

/// Two names of one number.
void check_twice(const System<double>& system, std::span<const FitParameter> parameters) {
  for (std::size_t i = 0; i < parameters.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const std::string &a = parameters[k].path, &b = parameters[i].path;
      if (a == b || a + ".1" == b || a == b + ".1") throw UsageError(a + ": asked for twice");
      const auto same = [&](const std::string& shared, const std::string& own) {
        return shared.starts_with("optics.") && own.substr(own.rfind('.') + 1) == shared.substr(7) &&
               falls_back(system, own);
      };
      const auto pitch = [](const std::string& p) { return p.starts_with("frame.pitch"); };
      if (same(a, b) || same(b, a) || (pitch(a) && pitch(b) && (a == "frame.pitch" || b == "frame.pitch")))
        throw UsageError(a + " and " + b + " are the same number; fit one of them");
    }
}

void check_data(const FitData& data) {
  if (data.conditions.empty()) throw UsageError("fit: no sensor given");
  const auto condition = [&](const std::string& name, std::size_t index) {
    if (index >= data.conditions.size())
      throw UsageError(name + ": condition " + std::to_string(index) + " of " + std::to_string(data.conditions.size()));
  };
  const auto region = [](const std::string& name, const Roi& roi, const mtf::ImageView<const float>& image) {
    if (roi.x < 0 || roi.y < 0 || roi.width < 1 || roi.height < 1 || roi.x > image.width - roi.width ||
        roi.y > image.height - roi.height)
      throw UsageError(name + ": the region is not inside the image");
  };
  for (const EdgeData& edge : data.edges) {
    condition(edge.name, edge.condition);
    region(edge.name, edge.roi, edge.image);
    if (!(edge.quantum >= 0.0 && std::isfinite(edge.quantum))) throw UsageError(edge.name + ": quantum is 0 or more");
  }
  for (const CurveData& curve : data.curves) condition(curve.name, curve.condition);
  for (const SpotData& spot : data.spots) {
    condition(spot.name, spot.condition);
    region(spot.name, spot.roi, spot.image);
  }
  for (const System<double>& system : data.conditions) {
    require_valid(system);
    mtf::refuse_range(system, "a fit");
  }
  // A place in the image is one on the detector.
  const auto whole = [&](const std::string& name, std::size_t index, const mtf::ImageView<const float>& image) {
    const System<double>& system = data.conditions[index];
    const std::int64_t columns = system.frame.columns, rows = system.frame.rows;
    if (system.is_isoplanatic() || (image.width == columns && image.height == rows)) return;
    const auto size = [](std::int64_t x, std::int64_t y) { return std::to_string(x) + " x " + std::to_string(y); };
    throw UsageError(name + ": the OTF changes over the field, and the image has " + size(image.width, image.height) +
                     " pixels, frame.format " + (columns > 0 ? size(columns, rows) : "is not given") +
                     "; give the size of the detector there, and images of all of it");
  };
  for (const EdgeData& edge : data.edges) whole(edge.name, edge.condition, edge.image);
  for (const SpotData& spot : data.spots) whole(spot.name, spot.condition, spot.image);
}

/// The data that are taken under a condition: the first one by name; "" where there are none.
std::string data_under(const FitData& data, std::size_t condition) {
  std::string name;
  const auto look = [&](const auto& list) {
    const auto found = std::ranges::find(list, condition, [](const auto& one) { return one.condition; });
    if (name.empty() && found != list.end()) name = found->name;
  };
  look(data.edges);
  look(data.spots);
  look(data.curves);
  return name;
}

std::string trouble_of(const EdgeData& edge) {
  const EdgeMeasurement& start = edge.start;
  if (start.trouble != Trouble::none) return start.reason.empty() ? "its measurement failed" : start.reason;
  const double contrast = start.bright - start.dark;
  const EdgeCurve& curve = start.curve;
  bool finite = curve.half_length_px > 0.0;
  for (const double number : {contrast, curve.angle_rad, curve.origin.x, curve.origin.y, curve.half_length_px,
                              curve.curvature_per_px, start.noise_sd, start.noise_gain})
    finite = finite && std::isfinite(number);
  for (const double c : curve.coefficient) finite = finite && std::isfinite(c);
  if (!finite) return "its measurement is not finite";
  return contrast == 0.0 ? "there is no contrast" : "";
}

/// The two points of an edge whose mean stands for that over its length (Gauss): the OTF may change along it.
std::vector<Point> points_along(const EdgeMeasurement& edge) {
  const auto [x, y] = edge.curve.origin;
  if (!(edge.length_px > 0.0 && std::isfinite(edge.length_px))) return {{x, y}};
  const Point normal = edge.curve.normal();
  const double off = 0.5 * edge.length_px / std::numbers::sqrt3;
  return {{x - off * normal.y, y + off * normal.x}, {x + off * normal.y, y - off * normal.x}};
}

/// Whether the step response of the starting sensor can be computed over the edge's pixels.
std::string not_modelled(const EdgeBlock& block, const Sensors& sensors) {
  try {
    sensors.slice(block.place(), block.data().start.curve.angle_rad, block.range_px());
  } catch (const mtf::Error& error) {
    return error.what();
  }
  return "";
}

/// Of many blocks some, all over the image.
std::vector<Probe> probes_of(std::span<const Block> blocks) {
  const std::size_t every = std::max<std::size_t>(1, blocks.size() / kMostProbes);
  std::vector<Probe> probes;
  std::vector<double> f;
  for (int i = 1; i <= 12; ++i) f.push_back(0.05 * i);
  const auto add_direction = [&](std::size_t place, double angle) {
    if (probes.size() < kMostProbes) probes.push_back({place, along(angle, f), nullptr});
  };
  for (std::size_t b = 0; b < blocks.size(); b += every) {
    const Block& block = blocks[b];
    if (const auto* edge = std::get_if<EdgeBlock>(&block))
      add_direction(edge->place(), edge->data().start.curve.angle_rad);
    if (const auto* curve = std::get_if<CurveBlock>(&block))
      probes.push_back(
          {curve->place(), {curve->frequencies().begin(), curve->frequencies().end()}, curve->data().unit});
    if (const auto* spot = std::get_if<SpotBlock>(&block))
      for (const double angle : {0.0, 0.25 * std::numbers::pi, 0.5 * std::numbers::pi})
        add_direction(spot->place(), angle);
  }
  return probes;
}

/// A frequency at which the MTF of the data is about one half.
struct HalfContrast {
  std::size_t place = 0;
  PixelFreq f;
};

std::vector<HalfContrast> half_contrasts(std::span<const Block> blocks) {
  constexpr double kOfGaussian = 0.18739;  // f sigma at half contrast
  std::vector<HalfContrast> all;
  for (const Block& block : blocks) {
    if (const auto* edge = std::get_if<EdgeBlock>(&block)) {
      const EdgeMeasurement& start = edge->data().start;
      if (start.mtf50 && start.mtf50->value > 1e-4 && start.mtf50->value < 4.0)
        all.push_back({edge->place(), along(start.curve.angle_rad, {&start.mtf50->value, 1}).front()});
    }
    if (const auto* spot = std::get_if<SpotBlock>(&block))
      all.push_back({spot->place(), {kOfGaussian / spot->width_px(), 0.0, 0.0, 0.0}});
  }
  return all;
}

/// Whether a parameter is a size that blurs.
bool is_width(const Variable& variable, const mtf::FieldInfo& info) {
  using mtf::Dimension;
  const bool size =
      info.dimension == Dimension::length || info.dimension == Dimension::extent || info.dimension == Dimension::angle;
  return variable.squared || (size && info.lo == 0.0);
}

// Starting values. Widths far from the truth leave no gradient to follow: where the model's contrast is a tenth or nine
// tenths at the frequency at which the data have one half, all widths are multiplied by the factor that makes it one
// half.
std::vector<double> near_values(FitProblem& problem, std::span<const double> start,
                                std::span<const mtf::FieldInfo> infos) {
  const std::vector<HalfContrast> halves = half_contrasts(problem.blocks);
  const std::vector<double> given(start.begin(), start.end());
  std::vector<double> values;
  const auto contrast = [&](double factor) {
    values = given;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const Variable& v = problem.variables[i];
      if (problem.priors[i] || !is_width(v, infos[i])) continue;
      const double a = v.value(v.lo), b = v.value(v.hi);
      values[i] = std::clamp(values[i] * factor, std::min(a, b), std::max(a, b));
    }
    if (!problem.sensors->set(values)) return std::numeric_limits<double>::quiet_NaN();
    double sum = 0.0;
    for (const HalfContrast& half : halves) sum += problem.sensors->modulus(half.place, {&half.f, 1}).front();
    return sum / static_cast<double>(halves.size());
  };
  if (halves.empty()) return given;
  const double here = contrast(1.0);
  if (!(here < 0.1 || here > 0.9)) return given;
  double lo = here < 0.5 ? -30.0 : 0.0, hi = here < 0.5 ? 0.0 : 30.0;  // log of the factor
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (lo + hi), value = contrast(std::exp(middle));
    if (!std::isfinite(value)) return given;
    (value > 0.5 ? lo : hi) = middle;
  }
  return std::abs(contrast(std::exp(lo)) - 0.5) < 0.2 ? values : given;  // where no width gives one half
}

void check_constant_passes(const Sensors& sensors, std::size_t conditions) {
  const PixelFreq small{1e-9, 0.0, 0.0, 0.0};
  for (std::size_t c = 0; c < conditions; ++c)
    if (!std::isfinite(sensors.modulus(c, {&small, 1}).front()))
      throw UsageError(
          "fit: the sensor passes no constant signal (its OTF is 0 at f = 0), so that edges have no plateaus");
}

}  // namespace

FitSetup make_setup(const FitData& data, std::span<const FitParameter> parameters, const FitOptions& options) {
  check_data(data);
  if (parameters.empty())
    throw UsageError("fit: nothing to fit; mark parameters of the sensor file with { value = ..., fit = true }");
  if (parameters.size() > kMostParameters)
    throw UsageError("fit: " + std::to_string(parameters.size()) + " parameters, at most " +
                     std::to_string(kMostParameters));
  check_twice(data.conditions.front(), parameters);

  FitSetup setup;
  std::vector<std::string> paths;
  std::vector<mtf::FieldInfo> infos;
  for (const FitParameter& parameter : parameters) {
    paths.push_back(parameter.path);
    std::vector<double> first;
    for (std::size_t c = 0; c < data.conditions.size(); ++c) {
      System<double> system = data.conditions[c];
      const auto site = parameter_site(system, parameter.path);
      if (site.numbers.empty())
        throw UsageError(parameter.path + ": the sensor has no such number, or does not give it" +
                         (c > 0 ? " under condition " + std::to_string(c) : ""));
      std::vector<double> own;
      for (const double* number : site.numbers) own.push_back(*number);
      if (c == 0) first = own;
      if (const std::string where = own == first ? "" : data_under(data, c); !where.empty())
        throw UsageError(where + ": its condition sets " + (parameter.name.empty() ? parameter.path : parameter.name) +
                         ", which is fitted and so set alike for all data; leave it out of the conditions, or take "
                         "fit = true away from it");
      if (c > 0) continue;
      infos.push_back(site.info);
      setup.start.push_back(first.front());
    }
  }
  setup.sensors = std::make_unique<Sensors>(data.conditions, paths);
  FitProblem& problem = setup.problem;
  problem.sensors = setup.sensors.get();
  problem.threads = options.threads;
  check_constant_passes(*setup.sensors, data.conditions.size());

  const auto leave_out = [&](const std::string& name, const std::string& why) {
    setup.warnings.push_back(name + " was left out: " + why);
    setup.block_of.push_back(std::nullopt);
  };
  const auto take = [&](Block block) {
    setup.block_of.push_back(problem.blocks.size());
    problem.blocks.push_back(std::move(block));
  };
  for (const EdgeData& edge : data.edges) {
    if (const std::string why = trouble_of(edge); !why.empty()) {
      leave_out(edge.name, why);
      continue;
    }
    EdgeBlock block(edge);
    block.set_place(setup.sensors->place(edge.condition, points_along(edge.start)));
    if (const std::string why = not_modelled(block, *setup.sensors); !why.empty()) {
      leave_out(edge.name, why);
      continue;
    }
    if (block.thinned())
      setup.warnings.push_back(edge.name + ": of its many pixels a part is fitted, spread evenly; cut regions along " +
                               "the edge to use all");
    if (block.pixels() < 4 * (block.start().size() + parameters.size()))
      leave_out(edge.name, "only " + std::to_string(block.pixels()) + " pixels have a value");
    else
      take(std::move(block));
  }
  for (const CurveData& curve : data.curves) take(CurveBlock(curve));
  for (const SpotData& spot : data.spots) {
    SpotBlock block(spot);
    if (!block.reason().empty())
      leave_out(spot.name, block.reason());
    else {
      if (block.cut())
        setup.warnings.push_back(spot.name + ": of its region the " + std::to_string(block.roi().width) + " x " +
                                 std::to_string(block.roi().height) + " pixels around the peak are fitted");
      block.set_place(setup.sensors->place(spot.condition, {{block.x_px(), block.y_px()}}));
      take(std::move(block));
    }
  }

  for (const FitParameter& parameter : parameters) problem.priors.push_back(parameter.prior);
  const std::vector<Probe> probes = probes_of(problem.blocks);
  problem.variables = make_variables(*setup.sensors, parameters, setup.start, infos, probes, options.threads);
  const std::vector<double> near = near_values(problem, setup.start, infos);
  const std::vector<double> seen = seen_values(*setup.sensors, problem.variables, near, probes, options.threads);
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (seen[i] != near[i])
      setup.warnings.push_back(parameters[i].path +
                               ": so far up more or less of it changes nothing; the fit begins at " +
                               mtf::format_double(seen[i]) + " in place of " + mtf::format_double(near[i]));
  if (seen != setup.start)
    problem.variables = make_variables(*setup.sensors, parameters, seen, infos, probes, options.threads);
  for (const Variable& variable : problem.variables) problem.x.push_back(variable.start);
  problem.apply();
  for (const Block& block : problem.blocks)
    problem.own.push_back(std::visit([](const auto& b) { return b.start(); }, block));
  return setup;
}

std::vector<double> other_start(std::span<const Variable> variables, int run) {
  constexpr std::array kPrimes{2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37};
  std::vector<double> x;
  for (std::size_t i = 0; i < variables.size(); ++i) {
    const Variable& v = variables[i];
    double part = 0.0, digit = 1.0;
    const int prime = kPrimes[i % kPrimes.size()];
    for (int n = run + static_cast<int>(i / kPrimes.size()); n > 0; n /= prime) part += (digit /= prime) * (n % prime);
    // Ten unit effects in both directions, or down to a quarter and up to four times of a size, within the bounds.
    const bool size = v.positive && v.start > 0.0;
    const double lo = std::max(v.lo, size && !v.squared ? 0.25 * v.start : v.start - 10.0);
    const double hi = std::min(v.hi, size ? std::max(4.0 * v.start, v.squared ? 10.0 : 0.0) : v.start + 10.0);
    x.push_back(lo + part * (hi - lo));
  }
  return x;
}

}  // namespace calib
