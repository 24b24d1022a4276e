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

/// The statement of a parameter, open ends as infinite ones; nothing when none is made.
std::optional<std::array<double, 2>> stated(const FittedParameter& p) {
  constexpr double k95 = 1.959963984540054;
  if (p.interval95) return p.interval95;
  if (p.stderr_value) return std::array{p.value - k95 * *p.stderr_value, p.value + k95 * *p.stderr_value};
  if (!p.limit95) return std::nullopt;
  return std::array{std::min(p.value, *p.limit95), std::max(p.value, *p.limit95)};
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

Outcome run(const Case& one, int draws, std::uint64_t seed, const calib::FitOptions& options) {
  const double top = one.sensor.frame.pitch_x_um / (*one.sensor.optics.wavelength_um * *one.sensor.optics.f_number);
  const made::Step step([&](double f) { return fit_cases::mtf_along(one.sensor, one.angle_deg, f); }, top, 120.0);
  const double mtf50 = fit_cases::mtf50_along(one.sensor, one.angle_deg);
  mtf::System<double> start = one.sensor;
  std::vector<calib::FitParameter> parameters;
  for (const Truth& truth : one.fitted) {
    parameters.push_back(fit_cases::parameter(truth.path));
    if (truth.min) parameters.back().min = truth.min;
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
      const auto interval = stated(result.parameters[i]);
      held.silent += !interval;
      const auto& ends = result.parameters[i].interval;
      held.unbounded += ends && !(ends->low && ends->high);
      if (!interval) continue;
      const double slack = 1e-5;  // bounds stand a millionth off zero
      held.inside += one.fitted[i].value > (*interval)[0] - slack && one.fitted[i].value < (*interval)[1] + slack;
      held.width += ((*interval)[1] - (*interval)[0]) / draws;
    }
  }
  std::nth_element(times.begin(), times.begin() + draws / 2, times.end());
  out.ms = times[static_cast<std::size_t>(draws / 2)];
  return out;
}

}  // namespace flat_study
