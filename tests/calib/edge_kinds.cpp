// SPDX-License-Identifier: Apache-2.0
#include "tests/calib/edge_kinds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "tests/calib/made_defects.h"

namespace made {
namespace {

constexpr double kPi = std::numbers::pi, kContrast = 0.6;

double phi(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }
double gauss_otf(double sigma_px, double f) { return std::exp(-2.0 * std::pow(kPi * sigma_px * f, 2)); }

// A share of the light is spread by exp(-2 pi w f): a Lorentzian of half width w.
Step with_halo(const Step& core, double share, double half_width_px) {
  return Step::closed(
      [=](double d) { return (1.0 - share) * core.at(d) + share * (0.5 + std::atan(d / half_width_px) / kPi); },
      [=](double f) { return (1.0 - share) * core.mtf(f) + share * std::exp(-2.0 * kPi * half_width_px * f); });
}

// The same by a Laplacian, exp(-|d| / w), of which nothing is left beyond the region.
Step with_short_halo(const Step& core, double share, double length_px) {
  return Step::closed(
      [=](double d) {
        const double tail = 0.5 * std::exp(-std::abs(d) / length_px);
        return (1.0 - share) * core.at(d) + share * (d < 0.0 ? tail : 1.0 - tail);
      },
      [=](double f) { return (1.0 - share) * core.mtf(f) + share / (1.0 + std::pow(2.0 * kPi * length_px * f, 2)); });
}

// Behind a low-pass of one pole, whose corner is f3, the line spread has the tail exp(-d / tail). E is a solution of
// tail E' + E = core, here in steps so fine that straight lines in between are exact to 1e-6, about the location of
// least phase, sum of f |H| Im H = 0.
Step low_pass(const Step& core, double corner_cy_px) {
  constexpr double kStep_px = 1.0 / 256.0, kFar_px = 100.0;
  const double tail = 1.0 / (2.0 * kPi * corner_cy_px), x = kStep_px / tail, decay = std::exp(-x);
  const auto mtf = [=](double f) { return core.mtf(f) / std::hypot(1.0, f / corner_cy_px); };
  double shift = tail;
  for (int round = 0; round < 30; ++round) {
    double sum = 0.0, slope = 0.0;
    for (int i = 1; i <= 64; ++i) {  // the frequencies of the definition, 0 to 0.8 cycles per pixel
      const double f = 0.8 * i / 64.0, m = mtf(f), phase = 2.0 * kPi * f * shift - std::atan(f / corner_cy_px);
      sum += f * m * m * std::sin(phase);
      slope += 2.0 * kPi * f * f * m * m * std::cos(phase);
    }
    shift -= sum / slope;
  }
  auto table = std::make_shared<std::vector<double>>();
  double value = core.at(-kFar_px);
  for (int i = 0; i * kStep_px < 2.0 * kFar_px; ++i) {
    table->push_back(value);
    const double before = core.at(-kFar_px + i * kStep_px), after = core.at(-kFar_px + (i + 1) * kStep_px);
    value = decay * value + (1.0 - decay) * before + (1.0 - (1.0 - decay) / x) * (after - before);
  }
  return Step::closed(
      [=](double d) {
        const double at = std::clamp((d + shift + kFar_px) / kStep_px, 0.0, static_cast<double>(table->size() - 2));
        const auto i = static_cast<std::size_t>(at);
        return std::lerp((*table)[i], (*table)[i + 1], at - static_cast<double>(i));
      },
      mtf);
}

// An unsharp mask: H (1 + amount (1 - G)).
Step sharpened(double sigma_px, double radius_px, double amount) {
  const double wide_px = std::hypot(sigma_px, radius_px);
  return Step::closed(
      [=](double d) { return (1.0 + amount) * phi(d / sigma_px) - amount * phi(d / wide_px); },
      [=](double f) { return (1.0 + amount) * gauss_otf(sigma_px, f) - amount * gauss_otf(wide_px, f); });
}
Step sharpened_camera(const Camera& camera, double radius_px, double amount) {
  return Step(
      [=](double f) {
        return camera_otf(camera, 5.0 * kPi / 180.0, f) * (1.0 + amount * (1.0 - gauss_otf(radius_px, f)));
      },
      1.0 / camera.s, 120.0);
}

double footprint(double f) {  // of the pixel at 5 degrees
  const auto sinc = [](double x) { return x == 0.0 ? 1.0 : std::sin(kPi * x) / (kPi * x); };
  return sinc(f * std::cos(5.0 * kPi / 180.0)) * sinc(f * std::sin(5.0 * kPi / 180.0));
}

// Turbulence seen for long: exp(-(f / f0)^(5/3)), and the pixel.
Step turbulent(double f0_cy_px) {
  return Step([=](double f) { return footprint(f) * std::exp(-std::pow(f / f0_cy_px, 5.0 / 3.0)); }, 6.0 * f0_cy_px,
              120.0);
}

// Columns (rows) with an offset of their own, in parts of the noise of a pixel.
auto stripes(double columns, double rows) {
  return [=](mtf::Image& image, const Scene& scene, const Step&) {
    std::mt19937_64 bits(scene.seed ^ 0x2545f4914f6cdd1dU);
    std::normal_distribution<double> normal(0.0, scene.noise_sd);
    std::vector<double> column(static_cast<std::size_t>(image.width())), row(static_cast<std::size_t>(image.height()));
    for (double& one : column) one = columns * normal(bits);
    for (double& one : row) one = rows * normal(bits);
    for (std::int64_t j = 0; j < image.height(); ++j)
      for (std::int64_t i = 0; i < image.width(); ++i)
        image.at(i, j) += static_cast<float>(column[static_cast<std::size_t>(i)] + row[static_cast<std::size_t>(j)]);
  };
}

// Light that falls off with the square of the distance from a point, by `share` at the edge of 128 pixels.
auto vignetting(double share, double middle) {
  return [=](mtf::Image& image, const Scene& scene, const Step& step) {
    Scene quiet = scene;
    quiet.noise_sd = 0.0;
    const mtf::Image light = make(step, quiet);
    for (std::int64_t j = 0; j < image.height(); ++j)
      for (std::int64_t i = 0; i < image.width(); ++i) {
        const double x = (static_cast<double>(i) + 0.5 - middle * static_cast<double>(image.width())) / 64.0,
                     y = (static_cast<double>(j) + 0.5 - 0.5 * static_cast<double>(image.height())) / 64.0;
        image.at(i, j) -= static_cast<float>(share * (x * x + y * y)) * light.at(i, j);
      }
  };
}

using Maker = std::function<Step()>;  // steps are tabulated where they are asked for

struct Size {
  std::int64_t width, height;
};

Scene scene_of(const Size& size, double cnr) {
  return {.width = size.width, .height = size.height, .x = {}, .y = {}, .noise_sd = kContrast / cnr};
}

std::string name_of(const std::string& what, const Size& size, double cnr) {
  return what + " " + std::to_string(size.width) + "x" + std::to_string(size.height) + " CNR " +
         std::to_string(std::lround(cnr));
}

}  // namespace

std::vector<Kind> edge_kinds(std::string_view part) {
  std::vector<Kind> all;
  const auto add = [&](const std::string& what, const Maker& step, const Size& size, double cnr, double angle_deg = 5.0,
                       auto&&... spoil) -> Kind* {
    const std::string name = name_of(what, size, cnr);
    if (name.find(part) == std::string::npos) return nullptr;
    all.push_back({name, step(), scene_of(size, cnr), spoil...});
    all.back().scene.angle_deg = angle_deg;
    return &all.back();
  };
  const auto gaussian = [] { return Step::gaussian(0.3); };
  const auto soft = [] { return Step::gaussian(std::sqrt(0.5 * std::numbers::ln2) / (kPi * 0.92)); };
  const auto airy = [] {
    static const Step step = camera_step(camera_of(8.0), 5.0);
    return step;
  };
  const auto blurred = [](mtf::Image& image, const Scene& scene, const Step& step) {
    correlate_noise(image, scene, step, 1.0);
  };
  constexpr Size kSmall{40, 60}, kFlat{106, 28}, kUsual{128, 100};
  for (const auto& [size, half] : {std::pair{kSmall, 30.0}, {kFlat, 14.0}, {kUsual, 50.0}})
    for (const bool bent : {false, true})
      for (const bool shared : {false, true}) {
        const std::string what = std::string(bent ? "bent" : "straight") + (shared ? " shared noise" : "");
        Kind* one = shared ? add(what, soft, size, 20.0, -4.6, blurred) : add(what, soft, size, 20.0, -4.6);
        if (one == nullptr || !bent) continue;
        one->scene.sagitta_px = 0.86 * (size.width == 106 ? 1.0 : 2.0);
        one->scene.half_length_px = half;
      }
  for (const auto& [blur, core] : {std::pair<const char*, Maker>{"Airy", airy}, {"Gauss", gaussian}}) {
    const std::string of = std::string(" ") + blur;
    for (const Size& size : {kSmall, kUsual})
      for (const double cnr : {20.0, 60.0, 200.0}) {
        add("clean" + of, core, size, cnr);
        for (const double share : {0.01, 0.03, 0.1})
          for (const double px : {6.0, 12.0, 20.0, 40.0}) {
            const std::string how =
                std::to_string(std::lround(100.0 * share)) + " % " + std::to_string(std::lround(px)) + " px" + of;
            add(
                "halo " + how, [&] { return with_halo(core(), share, px); }, size, cnr);
            add(
                "short halo " + how, [&] { return with_short_halo(core(), share, px); }, size, cnr);
          }
        for (const double part_of_noise : {0.1, 0.25, 0.5})
          add("columns " + std::to_string(part_of_noise).substr(0, 4) + of, core, size, cnr, 5.0,
              stripes(part_of_noise, 0.0));
        add("rows 0.25" + of, core, size, cnr, 5.0, stripes(0.0, 0.25));
        for (const double share : {0.01, 0.03, 0.1}) {
          const std::string how = std::to_string(std::lround(100.0 * share)) + " %" + of;
          add("vignetting " + how, core, size, cnr, 5.0, vignetting(share, 0.5));
          add("vignetting aside " + how, core, size, cnr, 5.0, vignetting(share, 0.2));
        }
      }
  }
  Camera out_of_focus = camera_of(8.0);
  for (const Size& size : {kSmall, kUsual})
    for (const double cnr : {12.0, 20.0, 60.0, 200.0}) {
      const auto blur = [&](const std::string& what, double number, const Maker& step) {
        add(what + " " + std::to_string(number).substr(0, 4), step, size, cnr);
      };
      for (const double f0 : {0.25, 0.4, 0.8}) blur("turbulent", f0, [&] { return turbulent(f0); });
      for (const double corner : {0.25, 0.5}) {
        blur("low-pass Gauss 0.4", corner, [&] { return low_pass(Step::gaussian(0.4), corner); });
        blur("low-pass Airy", corner, [&] { return low_pass(airy(), corner); });
      }
      for (const double radius : {1.0, 2.0}) {
        blur("sharpened Gauss 0.5", radius, [&] { return sharpened(0.6, radius, 0.5); });
        blur("sharpened Gauss 1.5", radius, [&] { return sharpened(0.6, radius, 1.5); });
        blur("sharpened Airy 0.5", radius, [&] { return sharpened_camera(camera_of(8.0), radius, 0.5); });
      }
      for (const double waves : {0.2, 0.3, 0.6, 1.0}) {
        out_of_focus.w020 = waves;
        blur("defocus", waves, [&] { return camera_step(out_of_focus, 5.0); });
      }
    }
  return all;
}

std::array<double, kFigures> truth_of(const Step& step) {
  constexpr double kHalf_px = 1e-3;
  const auto lsf = [&](double d) { return (step.at(d + kHalf_px) - step.at(d - kHalf_px)) / (2.0 * kHalf_px); };
  double peak = 0.0, overshoot = -1.0;
  for (double d = -3.0; d <= 3.0; d += 1e-3)
    if (lsf(d) > lsf(peak)) peak = d;
  const auto side = [&](double sign) {
    double near = 0.0, far = 0.0;
    while (lsf(peak + sign * far) > 0.5 * lsf(peak)) near = far, far += 0.01;
    for (int round = 0; round < 40; ++round) {
      const double middle = 0.5 * (near + far);
      (lsf(peak + sign * middle) > 0.5 * lsf(peak) ? near : far) = middle;
    }
    return near;
  };
  double dark = -3.0, bright = 3.0;  // about where the step is half way up
  for (int round = 0; round < 50; ++round)
    (step.at(0.5 * (dark + bright)) < 0.5 ? dark : bright) = 0.5 * (dark + bright);
  for (double d = 1.0; d <= 3.0; d += 1e-3) overshoot = std::max(overshoot, step.at(dark + d) - 1.0);
  return {std::abs(step.mtf(0.05)),
          std::abs(step.mtf(0.1)),
          std::abs(step.mtf(0.25)),
          std::abs(step.mtf(0.5)),
          step.crossing(0.5),
          side(1.0) + side(-1.0),
          overshoot};
}

std::array<std::optional<calib::Estimate>, kFigures> figures_of(const calib::EdgeMeasurement& found) {
  const auto at = [&](double f) {
    const auto i = static_cast<std::size_t>(std::lround(f / calib::kCurveStep_cy_px));
    return calib::Estimate{found.mtf[i], found.mtf_sd[i]};
  };
  return {at(0.05), at(0.1), at(0.25), found.nyquist, found.mtf50, found.fwhm_px, found.overshoot};
}

Coverage coverage_of(Kind kind, int draws, std::uint64_t seed) {
  const std::array<double, kFigures> truth = truth_of(kind.step);
  std::mt19937_64 bits(seed);
  std::uniform_real_distribution<double> phase(-0.5, 0.5);
  Coverage all{.draws = draws};
  const auto without_numbers = [](std::string text) {
    std::erase_if(text, [](char c) { return (c >= '0' && c <= '9') || c == '.'; });
    return text;
  };
  for (int draw = 0; draw < draws; ++draw) {
    kind.scene.x = 0.5 * static_cast<double>(kind.scene.width) + phase(bits);
    kind.scene.y = 0.5 * static_cast<double>(kind.scene.height) + phase(bits);
    kind.scene.seed = bits();
    mtf::Image image = make(kind.step, kind.scene);
    if (kind.spoil) kind.spoil(image, kind.scene, kind.step);
    const calib::EdgeMeasurement found = calib::measure_edge(image.view(), {0, 0, image.width(), image.height()});
    if (found.trouble != calib::Trouble::none) {
      ++all.refused;
      all.words.push_back("REFUSED " + without_numbers(found.reason));
      continue;
    }
    all.warned += found.warnings.empty() ? 0 : 1;
    for (const std::string& warning : found.warnings) all.words.push_back(without_numbers(warning));
    const auto figures = figures_of(found);
    for (std::size_t k = 0; k < kFigures; ++k) {
      if (!figures[k]) continue;
      const double error = figures[k]->value - truth[k];
      ++all.stated[k];
      all.held[k] += std::abs(error) <= 1.96 * figures[k]->sd ? 1 : 0;
      all.bias[k] += error / figures[k]->sd;
      all.sd[k].push_back(figures[k]->sd);
      all.error[k].push_back(error);
    }
  }
  for (std::size_t k = 0; k < kFigures; ++k) all.bias[k] /= std::max(1, all.stated[k]);
  return all;
}

}  // namespace made
