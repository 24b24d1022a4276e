// SPDX-License-Identifier: Apache-2.0
#include "tests/calib/fit_study.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <numbers>
#include <random>

#include "tests/calib/fit_cases.h"

namespace fit_study {
namespace {

using calib::FitParameter;
using made::Scene;
using made::Step;

constexpr double kAngle_deg = 5.0;

Step step_of(const Case& one, double value) {
  if (one.model == Model::gaussian)
    return Step::gaussian(std::sqrt(0.5 * std::numbers::ln2) / (std::numbers::pi * value));
  made::Camera camera = made::camera_of(one.model == Model::camera ? value : 8.0);
  if (one.model != Model::camera) camera.w020 = value;
  return made::camera_step(camera, kAngle_deg);
}

double truth_of(const Case& one) {
  return one.model == Model::gaussian ? fit_cases::sigma_of(0.3) : one.model == Model::camera ? 8.0 : 0.3;
}

/// A sensor whose starting value is not the truth, and the path of the fitted parameter.
std::pair<mtf::System<double>, std::string> sensor_of(const Case& one) {
  const double start = 1.2 * truth_of(one);
  if (one.model == Model::gaussian) return {fit_cases::gaussian(start), "presample[0].sigma"};
  if (one.model == Model::camera) return {fit_cases::camera(start), "optics.f_number"};
  mtf::System<double> sensor = fit_cases::camera(8.0);
  const bool defocus = one.model == Model::defocus;
  auto pupil = mtf::Component<double>::make(defocus ? "defocus" : "wavefront");
  mtf::test::set(pupil, defocus ? "waves" : "w020", start);
  sensor.stages[0][0].component = pupil;
  return {std::move(sensor), defocus ? "presample[0].waves" : "presample[0].w020"};
}

Scene scene_of(const Case& one) {
  Scene scene;
  scene.height = one.rows;
  scene.half_length_px = 0.5 * static_cast<double>(one.rows);
  scene.angle_deg = kAngle_deg;
  scene.sagitta_px = one.sagitta_px;
  scene.x = 64.0;
  return scene;
}

Eigen::VectorXd pixels(const Step& step, const Scene& scene) {
  const mtf::Image image = made::make(step, scene);
  Eigen::VectorXd all(image.size());
  for (std::int64_t i = 0; i < image.size(); ++i) all[i] = image.data()[i];
  return all;
}

/// sd of the parameter, all of its companions unknown.
double bound(const Case& one, double truth) {
  const Scene scene = scene_of(one);
  const double h = 1e-3;  // images are float: 6e-8 / h of noise in a derivative
  std::vector<Eigen::VectorXd> columns;
  const auto difference = [&](const auto& changed) {
    const auto [up_step, up] = changed(h);
    const auto [down_step, down] = changed(-h);
    columns.push_back((pixels(up_step, up) - pixels(down_step, down)) / (2.0 * h));
  };
  const Step step = step_of(one, truth);
  difference([&](double by) { return std::pair(step_of(one, truth * (1.0 + 10.0 * by)), scene); });
  columns.back() /= 10.0;
  const auto moved = [&](auto change) {
    difference([&](double by) {
      Scene other = scene;
      change(other, by);
      return std::pair(step, other);
    });
  };
  moved([](Scene& s, double by) { *s.x += 10.0 * by; });
  moved([](Scene& s, double by) { s.angle_deg += 10.0 * by; });
  moved([](Scene& s, double by) { s.dark += by; });
  moved([](Scene& s, double by) { s.bright += by; });
  if (one.sagitta_px > 0.0) moved([](Scene& s, double by) { s.sagitta_px += 10.0 * by; });
  const auto n = static_cast<Eigen::Index>(columns.size());
  const double noise = 0.6 / one.cnr;
  Eigen::MatrixXd information(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index k = 0; k < n; ++k)
      information(i, k) =
          columns[static_cast<std::size_t>(i)].dot(columns[static_cast<std::size_t>(k)]) / (noise * noise);
  return std::sqrt(information.inverse()(0, 0));
}

struct Tally {
  double sum = 0.0, squares = 0.0, stated = 0.0, within68 = 0.0, within95 = 0.0, n = 0.0;
  void add(double error, double sd) {
    sum += error, squares += error * error, stated += sd * sd, n += 1.0;
    within68 += std::abs(error) <= 0.994457883209753 * sd;  // 68 % of a normal
    within95 += std::abs(error) <= 1.959963984540054 * sd;
  }
  double bias() const { return sum / n; }
  double sd() const { return std::sqrt((squares - sum * sum / n) / (n - 1.0)); }
};

}  // namespace

std::vector<Case> cases() {
  using enum Model;
  return {{"gauss30 cnr60 L100", gaussian, 100, 60.0},
          {"gauss30 cnr12 L100", gaussian, 100, 12.0},
          {"gauss30 cnr60 L32", gaussian, 32, 60.0},
          {"airy f8 cnr60 L100", camera, 100, 60.0},
          {"airy f8 cnr12 L100", camera, 100, 12.0},
          {"airy f8 cnr60 L32", camera, 32, 60.0},
          {"gauss30 cnr60 curved", gaussian, 100, 60.0, 1.5},
          {"gauss30 cnr60 8 bit", gaussian, 100, 60.0, 0.0, 1.0 / 255.0},
          {"defocus f8 cnr60", defocus, 100, 60.0},
          {"wavefront f8 cnr60", wavefront, 100, 60.0}};
}

Outcome run(const Case& one, int draws, std::uint64_t seed) {
  const double truth = truth_of(one);
  const Step step = step_of(one, truth);
  const double mtf50 = step.crossing(0.5);
  std::mt19937_64 bits(seed);
  std::uniform_real_distribution<double> phase(-0.5, 0.5);
  const auto [sensor, path] = sensor_of(one);
  const std::vector<FitParameter> parameters{fit_cases::parameter(path)};
  calib::FitOptions options;
  options.threads = 1;
  Outcome out;
  Tally parameter, half;
  double rms = 0.0;
  std::vector<double> times;
  for (int draw = 0; draw < draws; ++draw) {
    Scene scene = scene_of(one);
    *scene.x += phase(bits);
    scene.noise_sd = 0.6 / one.cnr;
    scene.quantum = one.quantum;
    scene.seed = bits();
    const mtf::Image image = made::make(step, scene);
    calib::EdgeData edge{.name = one.name,
                         .image = image.view(),
                         .roi = {0, 0, image.width(), image.height()},
                         .condition = 0,
                         .start = calib::measure_edge(image.view(), {0, 0, image.width(), image.height()}),
                         .quantum = one.quantum};
    const calib::FitData data = fit_cases::data_of(sensor, std::move(edge));
    const std::clock_t begin = std::clock();
    const calib::FitResult result = calib::fit(data, parameters, options);
    times.push_back(1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
    ++out.draws;
    out.flagged_wrong += result.status == calib::FitStatus::converged_model_wrong;
    const calib::FittedParameter& p = result.parameters.front();
    if (!p.stderr_value || !result.mtf50) {
      ++out.failed;
      continue;
    }
    parameter.add(p.value / truth - 1.0, *p.stderr_value / truth);
    half.add(result.mtf50->value / mtf50 - 1.0, result.mtf50->sd / mtf50);
    double squares = 0.0;
    for (int i = 0; i <= 100; ++i) squares += std::pow(result.mtf[i] - step.mtf(result.frequency_cy_px[i]), 2);
    rms += std::sqrt(squares / 101.0);
  }
  std::nth_element(times.begin(), times.begin() + draws / 2, times.end());
  out.ms = times[static_cast<std::size_t>(draws / 2)];
  out.bound = bound(one, truth);
  // MTF50 follows the one parameter.
  const double h = 1e-4;
  out.bound_mtf50 =
      out.bound *
      std::abs(step_of(one, truth * (1.0 + h)).crossing(0.5) - step_of(one, truth * (1.0 - h)).crossing(0.5)) /
      (2.0 * h * mtf50);
  out.bias = parameter.bias(), out.sd = parameter.sd(), out.stated = std::sqrt(parameter.stated / parameter.n);
  out.bias_mtf50 = half.bias(), out.sd_mtf50 = half.sd(), out.stated_mtf50 = std::sqrt(half.stated / half.n);
  out.cover68 = parameter.within68 / parameter.n, out.cover95 = parameter.within95 / parameter.n;
  out.cover68_mtf50 = half.within68 / half.n, out.cover95_mtf50 = half.within95 / half.n;
  out.rms_mtf = rms / parameter.n;
  return out;
}

}  // namespace fit_study
