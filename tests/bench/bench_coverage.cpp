// SPDX-License-Identifier: Apache-2.0
// How often the stated 95 % intervals of measure_edge hold on edges with a defect, beside the same edges without it.
// Each draw has its own noise and sub-pixel phase; the truth is the analytic MTF.
//   bench_coverage [draws = 400] [seed = 1] [part of a case's name]
// A column is a figure: percentage of the intervals that hold, and the median interval in parts of the one without the
// defect; of "rounded" edges, along the pixels' grid, noise and contrast are in steps. At the end: percentage of edges
// refused, of those with a warning, processor time of an edge, and the reason or warning that is stated most often.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "calib/find/find_edges.h"
#include "calib/measure/measure.h"
#include "tests/calib/made_defects.h"
#include "tests/calib/made_edges.h"

namespace {

using Defect = std::function<void(mtf::Image&, const made::Scene&, const made::Step&)>;

struct Case {
  std::string name;
  made::Step step;
  made::Scene scene;
  Defect defect;  ///< none: the case itself is the difficulty
  calib::MeasureOptions options{};
  bool find = false;  ///< the region is the first one that find_edges returns, otherwise the whole image
};

struct Size {
  std::int64_t width, height;
};
constexpr std::array<Size, 4> kSizes{{{24, 24}, {40, 60}, {128, 100}, {200, 300}}};
constexpr double kDark = 0.2, kContrast = 0.6;

std::string size_name(const Size& size, double cnr) {
  return " " + std::to_string(size.width) + "x" + std::to_string(size.height) +
         (cnr < 1e6 ? " CNR " + std::to_string(std::lround(cnr)) : " no noise");
}

made::Scene scene_of(const Size& size, double cnr) {
  return {.width = size.width,
          .height = size.height,
          .x = {},
          .y = {},
          .dark = kDark,
          .bright = kDark + kContrast,
          .noise_sd = cnr < 1e6 ? kContrast / cnr : 0.0};
}

std::vector<Case> cases(std::string_view wanted) {
  const made::Step gaussian = made::Step::gaussian(0.3), airy = made::camera_step(made::camera_of(8.0), 5.0);
  std::vector<Case> all;
  const auto add = [&](Case one) {
    if (one.name.find(wanted) != std::string::npos) all.push_back(std::move(one));
  };
  for (const auto& [blur, step] : {std::pair{"Gauss", gaussian}, {"Airy", airy}}) {
    for (const Size& size : kSizes) {
      for (const double cnr : {12.0, 30.0, 60.0}) {
        const made::Scene scene = scene_of(size, cnr);
        const std::string name = std::string(blur) + size_name(size, cnr);
        add({"clean " + name, step, scene, {}});
        for (const double sds : {1.5, 2.5}) {
          made::Scene low = scene;
          low.dark = sds * scene.noise_sd;
          low.bright = low.dark + kContrast;
          const std::string floor = "floor " + std::to_string(sds).substr(0, 3) + " sd ";
          const auto cut = [](mtf::Image& image, const made::Scene&, const made::Step&) {
            made::cut_off_below(image, 0.0);
          };
          add({floor + name, step, low, cut, {.floor = 0.0}});
          add({floor + "unknown " + name, step, low, cut});
        }
      }
      for (const double cnr : {12.0, 40.0, 1e9})
        for (const double more : {0.3, 1.0}) {
          const auto heat = [more](mtf::Image& image, const made::Scene& scene, const made::Step&) {
            made::heat_pixels(image, 0.002, more, scene.seed);
          };
          const std::string name = "hot " + std::to_string(more).substr(0, 3) + " " + blur + size_name(size, cnr);
          add({name, step, scene_of(size, cnr), heat});
          if (size.width >= 128) add({"found " + name, step, scene_of(size, cnr), heat, {}, true});
        }
      for (const double cnr : {4.0, 6.0})
        add({"low " + std::string(blur) + size_name(size, cnr), step, scene_of(size, cnr), {}});
      for (const double cnr : {12.0, 30.0, 60.0}) {
        const std::string name = std::string(blur) + size_name(size, cnr);
        const auto blurred = [](mtf::Image& image, const made::Scene& scene, const made::Step& one) {
          made::correlate_noise(image, scene, one, 0.8);
        };
        add({"correlated " + name, step, scene_of(size, cnr), blurred});
        add({"demosaiced " + name, step, scene_of(size, cnr), made::interpolate_noise});
        add({"compressed " + name, step, scene_of(size, cnr), made::compress_noise});
      }
    }
    for (const double apart_px : {20.0, 30.0, 45.0})
      for (const double cnr : {12.0, 30.0, 60.0, 1e9})
        add({"second " + std::to_string(std::lround(apart_px)) + " px " + blur + size_name(kSizes[2], cnr),
             step,
             scene_of(kSizes[2], cnr),
             [apart_px](mtf::Image& image, const made::Scene& scene, const made::Step& one) {
               made::add_second_edge(image, scene, one, apart_px, -kContrast);
             },
             {},
             true});
  }
  made::Camera defocused = made::camera_of(8.0);
  defocused.w020 = 1.0;
  for (const double cnr : {12.0, 30.0, 60.0, 1e9})
    for (const Size& size : {kSizes[1], kSizes[2]})
      add({"defocus 1.0" + size_name(size, cnr), made::camera_step(defocused, 5.0), scene_of(size, cnr), {}});
  for (const double angle_deg : {0.0, 45.0, 90.0})
    for (const auto& [blur, step] :
         {std::pair{"Gauss", gaussian}, {"Airy", made::camera_step(made::camera_of(8.0), angle_deg)}})
      for (const Size& size : {kSizes[0], kSizes[1], kSizes[2]})
        for (const double steps : {20.0, 60.0, 150.0})
          for (const double noise : {0.05, 0.1, 0.125, 0.25, 0.5, 1.0}) {
            made::Scene scene = scene_of(size, steps / noise);
            scene.angle_deg = angle_deg;
            scene.quantum = kContrast / steps;
            add({"rounded " + std::to_string(std::lround(angle_deg)) + " deg " + blur + " " +
                     std::to_string(size.width) + "x" + std::to_string(size.height) + " " +
                     std::to_string(noise).substr(0, 5) + " of " + std::to_string(std::lround(steps)),
                 step,
                 scene,
                 {},
                 {.quantum = scene.quantum}});
          }
  return all;
}

constexpr std::array<const char*, 5> kFigures{"MTF(.05)", "MTF(.1)", "MTF(.25)", "MTF50", "Nyquist"};

std::array<std::optional<calib::Estimate>, 5> figures_of(const calib::EdgeMeasurement& found) {
  const auto at = [&](double f) {
    const auto i = static_cast<std::size_t>(std::lround(f / calib::kCurveStep_cy_px));
    return calib::Estimate{found.mtf[i], found.mtf_sd[i]};
  };
  return {at(0.05), at(0.1), at(0.25), found.mtf50, found.nyquist};
}

struct Tally {
  double held = 0.0, squares = 0.0, bias = 0.0, worst = 0.0;
  std::vector<double> sd;
  void add(const calib::Estimate& one, double truth) {
    const double z = (one.value - truth) / one.sd;
    held += std::abs(z) <= 1.96 ? 1.0 : 0.0;
    squares += z * z;
    bias += z;
    worst = std::max(worst, std::abs(z));
    sd.push_back(one.sd);
  }
  double median() {
    if (sd.empty()) return NAN;
    const auto middle = sd.begin() + static_cast<std::ptrdiff_t>(sd.size() / 2);
    std::nth_element(sd.begin(), middle, sd.end());
    return *middle;
  }
};

std::string without_numbers(std::string text) {
  text.erase(std::remove_if(text.begin(), text.end(), [](char c) { return (c >= '0' && c <= '9') || c == '.'; }),
             text.end());
  return text;
}

void run(Case& one, int draws, std::uint64_t seed) {
  const std::array<double, 5> truth{std::abs(one.step.mtf(0.05)), std::abs(one.step.mtf(0.1)),
                                    std::abs(one.step.mtf(0.25)), one.step.crossing(0.5), std::abs(one.step.mtf(0.5))};
  std::mt19937_64 bits(seed);
  std::uniform_real_distribution<double> phase(-0.5, 0.5);
  std::array<Tally, 5> tallies, clean;
  std::map<std::string, int> words;
  int refused = 0, warned = 0;
  std::clock_t time = 0;
  const auto region_of = [&](const mtf::Image& image) -> std::optional<calib::Roi> {
    if (!one.find) return calib::Roi{0, 0, image.width(), image.height()};
    const calib::FoundEdges found = calib::find_edges(image.view());
    if (found.edges.empty()) return std::nullopt;
    return found.edges.front().roi;
  };
  for (int draw = 0; draw < draws; ++draw) {
    one.scene.x = 0.5 * static_cast<double>(one.scene.width) + phase(bits);
    one.scene.y = 0.5 * static_cast<double>(one.scene.height) + phase(bits);
    if (one.scene.quantum > 0.0) {  // plateaus at any place between two steps
      one.scene.dark = kDark + one.scene.quantum * phase(bits);
      one.scene.bright = kDark + kContrast + one.scene.quantum * phase(bits);
    }
    one.scene.seed = bits();
    mtf::Image image = made::make(one.step, one.scene);
    if (one.defect) {
      if (const auto roi = region_of(image)) {
        const calib::EdgeMeasurement found = calib::measure_edge(image.view(), *roi);
        if (found.trouble == calib::Trouble::none) {
          const auto figures = figures_of(found);
          for (std::size_t k = 0; k < figures.size(); ++k)
            if (figures[k]) clean[k].add(*figures[k], truth[k]);
        }
      }
      one.defect(image, one.scene, one.step);
    }
    const auto roi = region_of(image);
    if (!roi) {
      ++refused;
      ++words["no region found"];
      continue;
    }
    const std::clock_t before = std::clock();
    const calib::EdgeMeasurement found = calib::measure_edge(image.view(), *roi, one.options);
    time += std::clock() - before;
    if (found.trouble != calib::Trouble::none) {
      ++refused;
      ++words["REFUSED " + without_numbers(found.reason)];
      continue;
    }
    warned += found.warnings.empty() ? 0 : 1;
    for (const std::string& warning : found.warnings) ++words[without_numbers(warning)];
    const auto figures = figures_of(found);
    for (std::size_t k = 0; k < figures.size(); ++k)
      if (figures[k]) tallies[k].add(*figures[k], truth[k]);
  }
  std::printf("%-38s", one.name.c_str());
  for (std::size_t k = 0; k < tallies.size(); ++k) {
    const double count = static_cast<double>(tallies[k].sd.size());
    const double median = tallies[k].median();
    std::printf(" %5.1f %+5.2f %4.2f |", 100.0 * tallies[k].held / count, tallies[k].bias / count,
                one.defect ? median / clean[k].median() : median / truth[k] * 100.0);
  }
  std::printf(" %5.1f %5.1f %5.2f", 100.0 * refused / draws, 100.0 * warned / draws,
              1e3 * static_cast<double>(time) / CLOCKS_PER_SEC / draws);
  const auto most =
      std::max_element(words.begin(), words.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  if (most != words.end()) std::printf("  %d x %.60s", most->second, most->first.c_str());
  std::printf("\n");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int draws = argc > 1 ? std::atoi(argv[1]) : 400;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  if (draws < 2) return 2;
  std::printf("%-38s", "held %, mean error / sd, interval");
  for (const char* figure : kFigures) std::printf(" %16s |", figure);
  std::printf(" %5s %5s %5s\n", "ref %", "warn", "ms");
  for (Case& one : cases(argc > 3 ? argv[3] : "")) run(one, draws, seed);
  return 0;
}
