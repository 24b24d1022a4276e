// SPDX-License-Identifier: Apache-2.0
#include "apps/characterize/page_figures.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <numeric>

#include "apps/characterize/number_words.h"
#include "apps/text/message_words.h"
#include "calib/characterize/spectra.h"
#include "calib/edge/median.h"
#include "calib/fit/fit_report.h"

namespace apps {
namespace {

using calib::Characterization, calib::Stack, calib::TransferLevel;

constexpr std::int64_t kMostPoints = 400;  // of a curve of one value a pixel

/// The fit between the levels: the dark, then lights in equal ratios, at the exposure times of the levels around them.
struct CurvePoint {
  double light = 0.0, time_s = 0.0;
  calib::PhotonTransfer::Level model;
};
std::vector<CurvePoint> fitted_curve(const Characterization& camera) {
  const std::vector<TransferLevel>& levels = camera.levels;  // by light
  const auto first = std::ranges::find_if(levels, [](const TransferLevel& l) { return l.light > 0.0; });
  std::vector<CurvePoint> curve;
  if (first == levels.end()) return curve;
  const auto add = [&](double light, double time_s) {
    curve.push_back({light, time_s, level_at(camera.transfer, light, time_s)});
  };
  if (levels.front().light == 0.0) add(0.0, levels.front().time_s);
  constexpr int kSteps = 200;
  const double least = 0.5 * first->light, most = levels.back().light;
  for (int k = 0; k <= kSteps; ++k) {
    const double light = least * std::pow(most / least, static_cast<double>(k) / kSteps);
    const auto next = std::ranges::find_if(levels, [&](const TransferLevel& l) { return l.light >= light; });
    const TransferLevel &b = next == levels.end() ? levels.back() : *next, &a = next > levels.begin() ? *(next - 1) : b;
    const double share = b.light > a.light ? (light - a.light) / (b.light - a.light) : 1.0;
    add(light, std::lerp(a.time_s, b.time_s, std::clamp(share, 0.0, 1.0)));
  }
  return curve;
}

/// Counts above the dark: of a point of the fit.
double signal_of(const Characterization& camera, const CurvePoint& point) {
  return point.model.mean - level_at(camera.transfer, 0.0, point.time_s).mean;
}

/// As measured, where there is a dark level: what the fit says of it, if it fails, bends no figure.
double signal_of(const Characterization& camera, const TransferLevel& level) {
  const TransferLevel& dark = camera.levels.front();
  const double measured = dark.light > 0.0 ? 0.0 : dark.mean - level_at(camera.transfer, 0.0, dark.time_s).mean;
  return level.mean - level_at(camera.transfer, 0.0, level.time_s).mean - measured;
}

/// How many neighbours are put together, so that there are few enough to draw.
std::int64_t group_of(std::int64_t values) { return (values + kMostPoints - 1) / kMostPoints; }

Figure figure_of(const std::string& title, const std::string& x_label, const std::string& y_label,
                 std::vector<Series> series) {
  Figure figure;
  figure.title = title;
  figure.x_label = x_label;
  figure.y_label = y_label;
  figure.series = std::move(series);
  return figure;
}

Series large_points(const std::string& name) { return {.name = name, .mark = Mark::large_points}; }

void put(Series& series, double x, double y) {
  series.x.push_back(x);
  series.y.push_back(y);
}

}  // namespace

std::vector<Figure> transfer_figures(const Characterization& camera) {
  Series used = large_points("stacks of the fit"), out = large_points("left out"), fit{.name = "fit"};
  Series means = large_points("of the mean"), variances = large_points("of the variance"), band{.name = "95 %"};
  double most = 3.0;
  for (std::size_t i = 0; i < camera.stacks.size(); ++i) {
    const calib::StackSummary& sums = camera.stacks[i].sums;
    if (camera.level_of[i] < 0) {
      put(out, sums.mean, sums.squares.value[radiometry::kTvh]);
      continue;
    }
    const auto k = static_cast<std::size_t>(camera.level_of[i]);
    const TransferLevel& level = camera.levels[k];
    const calib::PhotonTransfer::Level& model = camera.transfer.levels[k];
    put(used, level.mean, level.variance);
    put(means, level.mean, model.mean_z);
    if (level.variance_counts) put(variances, level.mean, model.variance_z);
    most = std::max({most, 1.1 * std::abs(model.mean_z), 1.1 * std::abs(model.variance_z)});
  }
  for (const CurvePoint& point : fitted_curve(camera)) put(fit, point.model.mean, point.model.variance);
  for (const double x : {used.x.front(), used.x.back()}) put(band, x, 0.0);
  band.low.assign(2, -calib::k95_sd);
  band.high.assign(2, calib::k95_sd);
  Figure transfer = figure_of("Variance over mean", "mean (counts)", "temporal variance (counts^2)", {used, fit, out});
  transfer.y_low = 0.0;
  Figure residuals = figure_of("Residuals of the fit", "mean (counts)", "measured - fit (standard deviations)",
                               {means, variances, band});
  residuals.y_low = -most;
  residuals.y_high = most;
  return {transfer, residuals};
}

std::vector<Figure> response_figures(const Characterization& camera, const std::string& light) {
  Series used = large_points("stacks of the fit"), out = large_points("left out"), fit{.name = "fit"};
  Series error = large_points("stacks"), curve{.name = "fit"}, band{.name = "noise, 95 %"};
  for (std::size_t i = 0; i < camera.stacks.size(); ++i)
    put(camera.level_of[i] < 0 ? out : used, camera.stacks[i].light, camera.stacks[i].sums.mean);
  double most = 0.0, by_light = 0.0, by_square = 0.0;  // of the relative least squares of signal - slope light
  for (const TransferLevel& level : camera.levels) most = std::max(most, signal_of(camera, level));
  const auto counts = [&](double signal, double at) { return at > 0.0 && signal >= 0.05 * most; };
  for (const TransferLevel& level : camera.levels) {
    const double signal = signal_of(camera, level), ratio = level.light / signal;
    if (!counts(signal, level.light)) continue;
    by_light += ratio;
    by_square += ratio * ratio;
  }
  const double slope = by_light / by_square;
  const TransferLevel& dark = camera.levels.front();
  const double dark_sd = dark.light > 0.0 ? camera.transfer.offset.sd : std::sqrt(dark.mean_variance);
  const auto percent = [&](double signal, double at) { return 100.0 * (signal / (slope * at) - 1.0); };
  for (const TransferLevel& level : camera.levels) {
    const double signal = signal_of(camera, level);
    if (!counts(signal, level.light)) continue;
    const double sd = std::hypot(std::sqrt(level.mean_variance) / signal, dark_sd / signal, level.light_sd);
    put(error, level.light, percent(signal, level.light));
    put(band, level.light, 0.0);
    band.low.push_back(-100.0 * calib::k95_sd * sd);
    band.high.push_back(100.0 * calib::k95_sd * sd);
  }
  for (const CurvePoint& point : fitted_curve(camera)) {
    put(fit, point.light, point.model.mean);
    const double signal = signal_of(camera, point);
    if (counts(signal, point.light)) put(curve, point.light, percent(signal, point.light));
  }
  return {figure_of("Response", light, "mean (counts)", {used, fit, out}),
          figure_of("Linearity error", light, "deviation from the line (%)", {error, curve, band})};
}

std::vector<Figure> sitf_figures(const Characterization& camera, const std::string& light) {
  Series used = large_points("blackbodies of the fit"), out = large_points("left out"), fit{.name = "fit"};
  Series error = large_points("blackbodies"), band{.name = "95 %"};
  double most = 3.0;
  for (std::size_t i = 0; i < camera.stacks.size(); ++i) {
    const Stack& stack = camera.stacks[i];
    put(camera.level_of[i] < 0 ? out : used, stack.light, stack.sums.mean);
    if (camera.level_of[i] < 0) continue;
    const calib::PhotonTransfer::Level& model = camera.transfer.levels[static_cast<std::size_t>(camera.level_of[i])];
    put(fit, stack.light, model.mean);
    put(error, stack.light, model.mean_z);
    put(band, stack.light, 0.0);
    most = std::max(most, 1.1 * std::abs(model.mean_z));
  }
  std::vector<Figure> figures{figure_of("Counts over radiance", light, "mean (counts)", {used, fit, out})};
  if (camera.transfer.dof == 0) return figures;
  band.low.assign(band.x.size(), -calib::k95_sd);
  band.high.assign(band.x.size(), calib::k95_sd);
  figures.push_back(figure_of("Residuals of the line", light, "measured - fit (standard deviations)", {error, band}));
  figures.back().y_low = -most;
  figures.back().y_high = most;
  return figures;
}

Figure snr_figure(const Characterization& camera, const std::string& light, bool is_photons) {
  Series measured = large_points("stacks"), fit{.name = "fit"}, total{.name = "with fixed patterns"};
  Series ideal{.name = is_photons ? "every photon counted" : "shot noise alone"};
  for (const TransferLevel& level : camera.levels)
    if (level.light > 0.0) put(measured, level.light, signal_of(camera, level) / std::sqrt(level.variance));
  const auto value = [&](const char* name) {
    const calib::Finding* const f = camera.find(name);
    return f != nullptr && f->verdict == calib::Verdict::determined ? f->value : 0.0;
  };
  const double dark =
      std::hypot(value("dsnu"), value("fixed_row"), value("fixed_column")) / value("electrons_per_count");
  const double bright = std::hypot(value("prnu"), value("prnu_row"), value("prnu_column"));
  for (const CurvePoint& point : fitted_curve(camera)) {
    if (!(point.light > 0.0)) continue;
    const double signal = signal_of(camera, point), variance = point.model.variance;
    put(fit, point.light, signal / std::sqrt(variance));
    put(total, point.light, signal / std::hypot(std::sqrt(variance), dark, bright * signal));
    put(ideal, point.light, std::sqrt(is_photons ? point.light : camera.find("rate")->value * point.light));
  }
  Figure figure = figure_of("Signal to noise of a pixel", light, "signal / noise", {measured, fit, ideal});
  if (dark > 0.0 || bright > 0.0) figure.series.push_back(total);
  figure.log_x = figure.log_y = true;
  return figure;
}

Figure spectrum_figure(const PatternPlane& p) {
  mtf::Image plane = p.plane.clone();
  for (const calib::Defect& d : p.squares.defects) plane.at(d.x, d.y) -= static_cast<float>(d.excess);
  Figure figure = figure_of("Spectrogram of the " + p.name, "frequency (cycles per pixel)",
                            "root of the mean power (" + p.unit + " rms)", {});
  for (const auto& [name, axis, n] : {std::tuple{"along rows", calib::LineAxis::rows, plane.width()},
                                      std::tuple{"along columns", calib::LineAxis::columns, plane.height()}}) {
    const std::vector<double> power = calib::line_spectrum(plane.view(), axis);
    const std::size_t count = power.size(), group = static_cast<std::size_t>(group_of(std::ssize(power)));
    Series series{.name = name};
    for (std::size_t from = 0; from < count; from += group) {
      const std::size_t to = std::min(count, from + group);
      const double sum = std::accumulate(power.begin() + static_cast<std::ptrdiff_t>(from),
                                         power.begin() + static_cast<std::ptrdiff_t>(to), 0.0);
      put(series, 0.5 * static_cast<double>(from + to + 1) / static_cast<double>(n),
          std::sqrt(sum / static_cast<double>(to - from)));
    }
    figure.series.push_back(std::move(series));
  }
  for (const auto& [name, rms] :
       {std::pair{"pattern of pixels", p.rms()}, std::pair{"left of temporal noise", std::sqrt(p.temporal2)}})
    figure.series.push_back({.name = name, .x = {0.0, 0.5}, .y = {rms, rms}});
  figure.x_range = {0.0, 0.5};
  figure.log_y = true;
  return figure;
}

std::vector<Figure> profile_figures(const Stack& stack, const std::string& name) {
  const mtf::Image& plane = stack.sums.pattern;
  std::vector<Figure> figures;
  for (const bool columns : {true, false}) {
    const std::int64_t n = columns ? plane.width() : plane.height(), across = plane.size() / n;
    Series means{.name = "mean, least to most"};
    for (std::int64_t from = 0, group = group_of(n); from < n; from += group) {
      const std::int64_t to = std::min(n, from + group);
      double sum = 0.0, low = HUGE_VAL, high = -HUGE_VAL;
      for (std::int64_t i = from; i < to; ++i)
        for (std::int64_t k = 0; k < across; ++k) {
          const double v = stack.sums.mean + static_cast<double>(columns ? plane.at(i, k) : plane.at(k, i));
          sum += v;
          low = std::min(low, v);
          high = std::max(high, v);
        }
      put(means, 0.5 * static_cast<double>(from + to - 1), sum / static_cast<double>((to - from) * across));
      means.low.push_back(low);
      means.high.push_back(high);
    }
    Figure figure = figure_of("Profile of the " + name + (columns ? " over columns" : " over rows"),
                              columns ? "column" : "row", "counts", {means});
    const auto [low, high] = std::ranges::minmax(means.y);
    std::vector<double> lows = means.low, highs = means.high;
    const double room = 2.0 * std::min(low - calib::median(lows), calib::median(highs) - high);
    if (room > 0.0) {
      figure.y_low = low - room;
      figure.y_high = high + room;
    }
    figures.push_back(std::move(figure));
  }
  return figures;
}

std::vector<Figure> histogram_figures(const PatternPlane& p) {
  const double sd = std::sqrt(p.squares.pixel), width = sd / 8.0, n = static_cast<double>(p.plane.size());
  if (!(sd > 0.0)) return {};
  std::vector<float> sizes;  // as many as pixels
  sizes.reserve(static_cast<std::size_t>(p.plane.size()));
  std::map<long, double> bins;
  for (std::int64_t y = 0; y < p.plane.height(); ++y)
    for (std::int64_t x = 0; x < p.plane.width(); ++x) {
      const double v = p.squares.deviation(p.plane.view(), x, y);
      if (std::abs(v) <= 10.0 * sd) ++bins[std::lround(v / width)];
      sizes.push_back(static_cast<float>(std::abs(v)));
    }
  Series found{.name = "pixels", .mark = Mark::points}, larger = found;
  for (const auto& [bin, count] : bins) put(found, width * static_cast<double>(bin), count);
  Series whole{.name = "normal, as measured"}, pattern{.name = "normal, pattern alone"}, expected = whole;
  const auto density = [&](double v, double of_sd) {
    return n * width / of_sd * std::exp(-0.5 * v * v / (of_sd * of_sd)) / std::sqrt(2.0 * std::numbers::pi);
  };
  for (double v = -6.0 * sd; v <= 6.0 * sd; v += 0.05 * sd) {
    if (density(v, sd) >= 0.5) put(whole, v, density(v, sd));
    if (p.rms() > 0.0 && density(v, p.rms()) >= 0.5) put(pattern, v, density(v, p.rms()));
    if (const double more = n * std::erfc(v / sd / std::numbers::sqrt2); v >= 0.1 * sd && more >= 0.5)
      put(expected, v, more);
  }
  std::ranges::sort(sizes, std::greater());
  for (std::size_t rank = 0; rank < sizes.size() && static_cast<double>(sizes[rank]) > 0.1 * sd; rank += 1 + rank / 40)
    put(larger, static_cast<double>(sizes[rank]), static_cast<double>(rank + 1));
  std::vector<Figure> figures{
      figure_of("Histogram of the " + p.name, "deviation (" + p.unit + ")", "pixels in a bin", {found, whole, pattern}),
      figure_of("Accumulated histogram of the " + p.name, "size of the deviation (" + p.unit + ")",
                "pixels that deviate by more", {larger, expected})};
  for (Figure& figure : figures) {
    figure.log_y = true;
    figure.y_low = 0.5;
  }
  figures[1].log_x = true;
  return figures;
}

std::string component_bars(const Characterization& camera, const Stack& stack) {
  using namespace radiometry;
  const NoiseUnit unit = noise_unit(camera);
  std::vector<Bar> bars;
  for (const auto& [part, name] :
       {std::pair{kTvh, "noise_tvh"}, std::pair{kTv, "noise_tv"}, std::pair{kTh, "noise_th"}, std::pair{kT, "noise_t"},
        std::pair{kVh, "noise_vh"}, std::pair{kV, "noise_v"}, std::pair{kH, "noise_h"}}) {
    const calib::VarianceComponent c = calib::variance_component(stack.sums.squares, part);
    const auto root = [&](double v) { return unit.per_count * std::sqrt(std::max(0.0, v)); };
    Bar bar{.label = std::string(number_words(name)),
            .value = root(c.variance),
            .interval = Ends{root(c.low95), root(c.high95)}};
    bar.label.pop_back();                                                   // the full stop
    if (const calib::Finding* const f = camera.find(name); f != nullptr) {  // with the error of SiTF
      bar.value = f->value;
      bar.interval = Ends{f->low95, f->high95};
    }
    bars.push_back(std::move(bar));
  }
  return svg_bars("Noise of " + stack.name, unit.name + " rms, with 95 % intervals", bars);
}

std::vector<Figure> time_figures(const Stack& stack, const NoiseUnit& unit) {
  const calib::StackSummary& sums = stack.sums;
  const radiometry::MeanSquares& squares = sums.squares;
  const calib::NoiseScales& noise = sums.noise;
  const auto root = [&](double v) { return unit.per_count * std::sqrt(v); };
  constexpr double kMany = 1e9;  // degrees of freedom: chi-square by F
  struct Power {
    double f, value, dof;
  };
  const auto figure = [&](const std::string& title, const std::vector<Power>& powers, double white) {
    Series measured = large_points("measured"), expected{.name = "white noise, 95 %"};
    for (const Power& power : powers) {
      put(measured, power.f, root(power.value));
      put(expected, power.f, root(white));
      expected.low.push_back(root(white * calib::f_quantile(0.025, power.dof, kMany)));
      expected.high.push_back(root(white * calib::f_quantile(0.975, power.dof, kMany)));
    }
    Figure f = figure_of(title + ": " + stack.name, "frequency (cycles per frame)",
                         "root of the mean power (" + unit.name + " rms)", {expected, measured});
    f.log_x = f.log_y = true;
    return f;
  };
  const double variance = calib::pixel_variance(squares), V = squares.rows, H = squares.columns,
               rows = std::ceil(V / static_cast<double>(noise.rows_apart)),
               relative = variance_of_products(sums, rows * H, rows);
  std::vector<Power> octaves, bands;
  for (std::size_t j = noise.mean.size(); j-- > 0;)
    octaves.push_back(
        {std::sqrt(0.125) * std::ldexp(1.0, -static_cast<int>(j)), noise.mean[j], noise.differences(j) / relative});
  const std::int64_t length = std::ssize(sums.frame_means);
  mtf::Image means(1, length);
  for (std::int64_t t = 0; t < length; ++t)
    means.at(0, t) = static_cast<float>(sums.frame_means[static_cast<std::size_t>(t)] - sums.mean);
  const std::vector<double> power = calib::line_spectrum(means.view(), calib::LineAxis::columns);
  for (std::int64_t k = 1, end = 0, n = std::ssize(power); k <= n; k = end) {
    end = std::min(n + 1, std::max(k + 1, k * 5 / 4));
    const auto count = static_cast<double>(end - k);
    const double sum = std::accumulate(power.begin() + k - 1, power.begin() + end - 1, 0.0);
    bands.push_back({0.5 * static_cast<double>(k + end - 1) / static_cast<double>(length), sum / count,
                     2.0 * count - (2 * (end - 1) == length ? 1.0 : 0.0)});
  }
  const double of_means =
      (squares.value[radiometry::kTv] + squares.value[radiometry::kTh] - squares.value[radiometry::kTvh]) / (V * H);
  std::vector<Figure> figures{figure("Noise of pixels by octaves", octaves, variance),
                              figure("Spectrum in time of the means of frames", bands, std::max(0.0, of_means))};

  Series found = large_points("pixels"), alike{.name = "were all alike"};
  const double bin = calib::variance_bin(sums), dof = squares.frames - 1.0;
  const auto share_above = [&](double k) { return calib::chi_square_tail(dof * std::exp(k * bin), dof); };
  for (const auto& [k, count] : calib::pixels_by_variance(sums))
    put(found, root(variance * std::exp(k * bin)), static_cast<double>(count));
  for (int k = -400; k <= 400; ++k)
    if (const double count = static_cast<double>(sums.variances.size()) * (share_above(k - 0.5) - share_above(k + 0.5));
        count >= 0.5)
      put(alike, root(variance * std::exp(k * bin)), count);
  figures.push_back(figure_of("Temporal noise of pixels: " + stack.name, "noise of a pixel (" + unit.name + " rms)",
                              "pixels in a bin", {found, alike}));
  figures.back().log_x = figures.back().log_y = true;
  figures.back().y_low = 0.5;
  return figures;
}

Figure defect_figure(const std::vector<PatternPlane>& planes) {
  Figure figure = figure_of("Defects", "x (pixels)", "y (pixels)", {});
  for (const PatternPlane& p : planes) {
    std::vector<calib::Defect> worst = p.squares.defects;
    std::ranges::stable_sort(worst, std::greater(), [](const calib::Defect& d) { return std::abs(d.excess); });
    worst.resize(std::min(worst.size(), kDefectsDrawn));
    Series series{.name = "of the " + p.name, .mark = Mark::points};
    for (const calib::Defect& d : worst) put(series, static_cast<double>(d.x) + 0.5, static_cast<double>(d.y) + 0.5);
    figure.series.push_back(std::move(series));
  }
  figure.x_range = {0.0, static_cast<double>(planes.front().plane.width())};
  figure.y_low = static_cast<double>(planes.front().plane.height());
  figure.y_high = 0.0;
  figure.equal_axes = true;
  return figure;
}

}  // namespace apps
