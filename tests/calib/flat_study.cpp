// SPDX-License-Identifier: Apache-2.0
#include "tests/calib/flat_study.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>
#include <random>

#include "tests/calib/fit_cases.h"

namespace flat_study {
namespace {

using calib::FittedParameter;

/// The statement of a parameter, one part or more; nothing when none is made.
std::vector<std::array<double, 2>> stated(const FittedParameter& p) {
  constexpr double k95 = 1.959963984540054;
  std::vector<std::array<double, 2>> parts;
  const auto add = [&](double value, const auto& interval, const auto& sd) {
    if (interval)
      parts.push_back(*interval);
    else if (sd)
      parts.push_back({value - k95 * *sd, value + k95 * *sd});
  };
  add(p.value, p.interval95, p.stderr_value);
  if (parts.empty() && p.limit95) parts.push_back({std::min(p.value, *p.limit95), std::max(p.value, *p.limit95)});
  for (const calib::OtherValue& other : p.others) add(other.value, other.interval95, other.stderr_value);
  return parts;
}

}  // namespace

Case diffusion(double diffusion_um) {
  Case one{.name = "diffusion " + std::to_string(diffusion_um), .sensor = fit_cases::camera(8.0), .fitted = {}};
  one.sensor.add(mtf::Stage::presample, mtf::test::jitter(2.5, "um"));
  auto spread = mtf::Component<double>::make("diffusion");
  mtf::test::set(spread, "absorption_length", 10.0);
  mtf::test::set(spread, "depletion_depth", 3.0);
  mtf::test::set(spread, "diffusion_length", std::max(1e-6, diffusion_um));
  one.sensor.add(mtf::Stage::presample, spread);
  one.fitted = {{"presample[2].rms", 2.5, 3.0}, {"presample[3].diffusion_length", diffusion_um, 3.0}};
  return one;
}

Case lens_and_jitter(double rms_um) {
  Case one{.name = "jitter " + std::to_string(rms_um), .sensor = fit_cases::camera(8.0), .fitted = {}};
  one.sensor.add(mtf::Stage::presample, mtf::test::jitter(rms_um, "um"));
  one.fitted = {{"optics.f_number", 8.0, 9.0}, {"presample[2].rms", rms_um, 1.5}};
  return one;
}

Case lens_out_of_focus(double waves) {
  Case one{.name = "defocus " + std::to_string(waves), .sensor = fit_cases::camera(8.0), .fitted = {}};
  auto pupil = mtf::Component<double>::make("defocus");
  mtf::test::set(pupil, "waves", waves);
  one.sensor.stages[0][0].component = pupil;
  one.fitted = {{"presample[0].waves", waves, 0.15}, {"optics.f_number", 8.0, 9.0}};
  return one;
}

Case two_footprints(double width_um) {
  Case one{.name = "second footprint " + std::to_string(width_um), .sensor = fit_cases::camera(8.0), .fitted = {}};
  one.sensor.add(mtf::Stage::presample, mtf::test::jitter(2.5, "um"));
  auto second = mtf::Component<double>::make("footprint");
  mtf::test::set(second, "width", width_um, "um");
  one.sensor.add(mtf::Stage::presample, second);
  one.fitted = {{"presample[2].rms", 2.5, 3.0}, {"presample[3].width", width_um, 3.0}};
  return one;
}

Case accelerated(double um_s2) {
  Case one{.name = "acceleration " + std::to_string(um_s2), .sensor = fit_cases::camera(8.0), .fitted = {}};
  one.at_rest = one.sensor;
  constexpr double kTime_s = 0.01, kSpeed_um_s = 200.0;
  constexpr int kPlaces = 64;
  const double along = std::cos(one.angle_deg * std::numbers::pi / 180.0) / fit_cases::kPitch_um;
  for (int k = 0; k < kPlaces; ++k) {
    const double t = kTime_s * ((k + 0.5) / kPlaces - 0.5);
    one.places_px.push_back(along * (kSpeed_um_s * t + 0.5 * um_s2 * t * t));
  }
  auto motion = mtf::Component<double>::make("accelerated_motion");
  mtf::test::set(motion, "velocity", kSpeed_um_s);
  mtf::test::set(motion, "acceleration", um_s2);
  one.sensor.add(mtf::Stage::presample, motion);
  one.fitted = {{"presample[2].acceleration", um_s2, 1e4, -1e6, 1e6}};
  return one;
}

Case out_of_focus(double waves) {
  Case one = lens_out_of_focus(waves);
  one.fitted.pop_back();
  return one;
}

Case two_aberrations(double w020, double w040) {
  Case one{.name = "aberrations " + std::to_string(w020) + " " + std::to_string(w040),
           .sensor = fit_cases::camera(8.0),
           .fitted = {}};
  auto pupil = mtf::Component<double>::make("wavefront");
  mtf::test::set(pupil, "w020", w020);
  mtf::test::set(pupil, "w040", w040);
  one.sensor.stages[0][0].component = pupil;
  one.fitted = {{"presample[0].w020", w020, 0.2, -2.0, 2.0}, {"presample[0].w040", w040, 0.1, -2.0, 2.0}};
  return one;
}

Case out_of_focus_aberrated(double waves) {
  Case one = two_aberrations(waves, 0.3);
  one.name = "defocus beside 0.3 " + std::to_string(waves);
  one.fitted.pop_back();
  return one;
}

Outcome run(const Case& one, int draws, std::uint64_t seed, const calib::FitOptions& options) {
  const mtf::System<double>& maker = one.places_px.empty() ? one.sensor : one.at_rest;
  const double top = maker.frame.pitch_x_um / (*maker.optics.wavelength_um * *maker.optics.f_number);
  made::Step step([&](double f) { return fit_cases::mtf_along(maker, one.angle_deg, f); }, top, 120.0);
  if (!one.places_px.empty()) step = step.moved(one.places_px);
  const double mtf50 = fit_cases::mtf50_along(one.sensor, one.angle_deg);
  mtf::System<double> start = one.sensor;
  std::vector<calib::FitParameter> parameters;
  for (const Truth& truth : one.fitted) {
    parameters.push_back(fit_cases::parameter(truth.path));
    parameters.back().min = truth.min;
    parameters.back().max = truth.max;
    calib::set_parameter(start, truth.path, truth.start);
  }
  std::mt19937_64 bits(seed);
  std::uniform_real_distribution<double> phase(-0.5, 0.5);
  Outcome out;
  out.draws = draws;
  out.parameters.resize(one.fitted.size());
  std::vector<double> times;
  for (int draw = 0; draw < draws; ++draw) {
    made::Scene scene;
    scene.angle_deg = one.angle_deg;
    scene.x = 64.0 + phase(bits);
    scene.noise_sd = 0.6 / one.cnr;
    scene.seed = bits();
    const mtf::Image image = made::make(step, scene);
    const calib::FitData data = fit_cases::data_of(start, fit_cases::edge_of(image, scene));
    const std::clock_t begin = std::clock();
    out.results.push_back(calib::fit(data, parameters, options));
    times.push_back(1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
    const calib::FitResult& result = out.results.back();
    out.failed += result.status != calib::FitStatus::converged;
    out.at_bound += std::any_of(result.parameters.begin(), result.parameters.end(),
                                [](const FittedParameter& p) { return p.knowledge == calib::Knowledge::at_bound; });
    out.inside_mtf50 += result.mtf50 && std::abs(result.mtf50->value - mtf50) < 1.959963984540054 * result.mtf50->sd;
    for (std::size_t i = 0; i < one.fitted.size(); ++i) {
      Held& held = out.parameters[i];
      const auto parts = stated(result.parameters[i]);
      held.silent += parts.empty();
      const auto& ends = result.parameters[i].interval;
      held.unbounded += ends && !(ends->low && ends->high);
      const auto holds = [&](double value) {
        const double slack = 1e-5;  // bounds stand a millionth off zero
        return std::any_of(parts.begin(), parts.end(), [&](const std::array<double, 2>& part) {
          return value > part[0] - slack && value < part[1] + slack;
        });
      };
      held.inside += holds(one.fitted[i].value);
      held.zero += holds(0.0);
      held.determined += result.parameters[i].knowledge == calib::Knowledge::determined;
      for (const std::array<double, 2>& part : parts) held.width += (part[1] - part[0]) / draws;
    }
  }
  std::nth_element(times.begin(), times.begin() + draws / 2, times.end());
  out.ms = times[static_cast<std::size_t>(draws / 2)];
  return out;
}

}  // namespace flat_study
