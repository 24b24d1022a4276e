// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/emva1288.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "calib/fit/fit_report.h"
#include "mtf/error.h"
#include "mtf/words.h"

namespace calib {
namespace {

using mtf::significant;
using radiometry::kH, radiometry::kT, radiometry::kTh, radiometry::kTv, radiometry::kTvh, radiometry::kV,
    radiometry::kVh, radiometry::MeanSquares;

enum EmvaPlace : std::size_t {
  kGain,
  kResponsivity,
  kQuantum,
  kDarkNoise,
  kReadNoise,
  kMinPhotons,
  kMinElectrons,
  kSatPhotons,
  kSatElectrons,
  kRange,
  kRangeDb,
  kSnr,
  kSnrDb,
  kLinearMin,
  kLinearMax,
  kDarkMean,
  kDarkVariance,
  kDsnu,  // each of the two whole, row, column, pixel
  kPrnu = kDsnu + 4,
  kEmvaPlaces = kPrnu + 4
};

/// Of the patterns the computation has the squares, which may be below 0.
using EmvaValues = std::array<double, kEmvaPlaces>;

struct EmvaText {
  std::string_view name, unit, from;
};
constexpr std::array<EmvaText, kEmvaPlaces> kTexts{
    {{"K", "DN/e-", "system gain: slope of the variance over the signal to 70 % of saturation"},
     {"R", "DN/p", "responsivity: slope of the signal over photons to 70 % of saturation"},
     {"eta", "%", "quantum efficiency: R / K"},
     {"sigma_y.dark", "DN", "temporal dark noise, rounding in it; sqrt(0.24) at least"},
     {"sigma_d", "e-", "temporal dark noise less 1/12 DN^2 for rounding"},
     {"mu_p.min", "p", "absolute sensitivity threshold"},
     {"mu_e.min", "e-", "absolute sensitivity threshold"},
     {"mu_p.sat", "p", "saturation capacity: the level of the largest variance"},
     {"mu_e.sat", "e-", "saturation capacity"},
     {"DR", "", "dynamic range: saturation over threshold"},
     {"DR_dB", "dB", "dynamic range"},
     {"SNR_max", "", "largest signal over noise: sqrt(mu_e.sat)"},
     {"SNR_max_dB", "dB", "largest signal over noise"},
     {"LE_min", "%", "linearity error, the least, 5 to 95 % of saturation"},
     {"LE_max", "%", "linearity error, the largest, 5 to 95 % of saturation"},
     {"mu_I.mean", "e-/s", "dark current from the dark means"},
     {"mu_I.var", "e-/s", "dark current from the dark variances"},
     {"DSNU", "e-", "dark signal nonuniformity"},
     {"DSNU_row", "e-", "its rows"},
     {"DSNU_column", "e-", "its columns"},
     {"DSNU_pixel", "e-", "its pixels"},
     {"PRNU", "%", "photo response nonuniformity"},
     {"PRNU_row", "%", "its rows"},
     {"PRNU_column", "%", "its columns"},
     {"PRNU_pixel", "%", "its pixels"}}};

constexpr double kFloor = 0.24;  // of the dark variance, counts^2

double square(double x) { return x * x; }

/// What the computation sees of a stack; its planes are the joint fit's.
struct EmvaStack {
  std::string name;
  double light = 0.0, time_s = 0.0;
  double clipped_low = 0.0;  ///< the share at the lower end, where it is too much
  double mean = 0.0;
  MeanSquares squares{};

  bool is_pair() const { return squares.frames == 2.0; }
  double variance() const {
    const double V = squares.rows, H = squares.columns;
    const auto& ms = squares.value;
    return ((V - 1.0) * ms[kTv] + (H - 1.0) * ms[kTh] + (V - 1.0) * (H - 1.0) * ms[kTvh]) / (V * H);
  }
};
using EmvaStacks = std::vector<EmvaStack>;

struct EmvaLevel {
  std::size_t bright = 0, dark = 0;  ///< stacks
  double signal(const EmvaStacks& stacks) const { return stacks[bright].mean - stacks[dark].mean; }
};

/// Spatial variances: whole, row, column, pixel.
std::array<double, 4> spatial(const EmvaStack& stack) {
  const MeanSquares& s = stack.squares;
  const double L = s.frames, M = s.rows, N = s.columns;
  const double temporal = (stack.variance() + s.value[kT] / (M * N)) / L;
  const auto of_mean = [&](radiometry::CubePart part) { return s.dof(part) * s.value[part] / L; };
  const double whole = (of_mean(kV) + of_mean(kH) + of_mean(kVh)) / (M * N - 1.0) - temporal;
  const double columns = of_mean(kH) / (M * N) - temporal / M, rows = of_mean(kV) / (M * N) - temporal / N;
  const double pixel = M * N / (M * N - M - N) * (whole - columns - rows);
  return {whole, rows - pixel / N, columns - pixel / M, pixel};
}

struct EmvaLine {
  double slope = 0.0, offset = 0.0;
};
EmvaLine line_of(const std::vector<double>& x, const std::vector<double>& y, const std::vector<double>& weight) {
  double w = 0.0, mx = 0.0, my = 0.0, xx = 0.0, xy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    w += weight[i];
    mx += weight[i] * x[i];
    my += weight[i] * y[i];
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += weight[i] * square(x[i] - mx / w);
    xy += weight[i] * (x[i] - mx / w) * (y[i] - my / w);
  }
  return {xy / xx, my / w - xy / xx * mx / w};
}

class Emva {
 public:
  Emva(std::vector<Stack> stacks, const CharacterizeOptions& options, bool counts_photons)
      : options_(options), counts_photons_(counts_photons) {
    std::stable_sort(stacks.begin(), stacks.end(), [](const Stack& a, const Stack& b) {
      return a.light != b.light ? a.light < b.light : a.time_s < b.time_s;
    });
    if (!stacks.empty() && std::min(stacks[0].sums.squares.rows, stacks[0].sums.squares.columns) < 3.0)
      throw mtf::UsageError("frames of fewer than three rows or columns; the standard's patterns need three");
    mark_stuck(stacks);
    for (const Stack& s : stacks)
      stacks_.push_back(
          {s.name, s.light, s.time_s, s.is_clipped_low() ? s.sums.share_low : 0.0, s.sums.mean, s.sums.squares});
    choose_levels();
    fit(std::move(stacks));
    saturation_ = saturation_of(stacks_);
    choose_patterns();
    add_numbers();
    add_notes();
  }

  Emva1288 take() { return std::move(result_); }

 private:
  std::size_t dark_of(std::size_t stack) const;
  void choose_levels();
  void fit(std::vector<Stack> stacks);
  std::size_t saturation_of(const EmvaStacks& stacks) const;
  void choose_patterns();
  EmvaValues values_of(const EmvaStacks& stacks, std::size_t saturation, double shift) const;
  EmvaValues spread_of(const EmvaValues& values) const;
  void add_numbers();
  void add_notes();
  void note_pattern(std::size_t place, const std::vector<const char*>& parts, double factor);
  void note_biases();

  CharacterizeOptions options_;
  bool counts_photons_;
  EmvaStacks stacks_;              ///< by light, then exposure, as in the joint fit
  std::vector<EmvaLevel> levels_;  ///< of photon transfer
  std::vector<std::size_t> dark_;
  std::size_t saturation_ = 0;  ///< a level
  std::optional<EmvaLevel> patterns_;
  Characterization joint_;
  Emva1288 result_;
};

/// The dark stack of its exposure, that of as many frames first, then of the most; the number of stacks for none.
std::size_t Emva::dark_of(std::size_t stack) const {
  const auto rank = [&](std::size_t i) {
    const double frames = stacks_[i].squares.frames;
    return frames == stacks_[stack].squares.frames ? std::numeric_limits<double>::infinity() : frames;
  };
  std::size_t best = stacks_.size();
  for (std::size_t i = 0; i < stacks_.size() && stacks_[i].light == 0.0; ++i)
    if (stacks_[i].time_s == stacks_[stack].time_s && (best == stacks_.size() || rank(i) > rank(best))) best = i;
  return best;
}

void Emva::choose_levels() {
  const auto count = [&](bool lit) {
    return std::count_if(stacks_.begin(), stacks_.end(),
                         [&](const EmvaStack& s) { return s.is_pair() && (s.light > 0.0) == lit; });
  };
  const bool pairs = count(true) >= 3, dark_pairs = pairs && count(false) > 0;
  for (std::size_t i = 0; i < stacks_.size(); ++i) {
    const EmvaStack& stack = stacks_[i];
    if (!stack.is_pair() && (stack.light > 0.0 ? pairs : dark_pairs)) continue;
    if (stack.light == 0.0) {
      dark_.push_back(i);
      continue;
    }
    levels_.push_back({i, dark_of(i)});
    if (levels_.back().dark == stacks_.size())
      throw mtf::UsageError(stack.name + ": no dark stack has its exposure, which EMVA 1288 subtracts; give one, or " +
                            "leave out --method emva1288");
  }
  if (levels_.size() < 3)
    throw mtf::UsageError("EMVA 1288 needs three levels with light at least, and asks for 50; there are " +
                          std::to_string(levels_.size()));
  result_.frames =
      std::to_string(levels_.size()) + " levels with light, " + (pairs ? "stacks of two frames" : "all frames of each");
}

void Emva::fit(std::vector<Stack> stacks) {
  joint_ = characterize(std::move(stacks), options_);
  while (joint_.misfit && options_.nonlinearity < 3) {
    ++options_.nonlinearity;
    try {
      joint_ = characterize(std::move(joint_.stacks), options_);
    } catch (const mtf::UsageError&) {
      break;  // too few levels for one more term
    }
  }
  result_.biases = joint_.misfit
                       ? "none but those of DSNU: the joint fit does not describe the frames: " + joint_.misfit_reason
                       : "by the joint fit with " + mtf::plural(std::ssize(joint_.transfer.a), "term") +
                             " of nonlinearity, p = " + significant(joint_.transfer.p, 2);
}

/// From the brightest level down until two in a row have less variance.
std::size_t Emva::saturation_of(const EmvaStacks& stacks) const {
  const auto variance = [&](std::size_t k) { return stacks[levels_[k].bright].variance(); };
  std::size_t best = levels_.size() - 1;
  for (std::size_t k = best; k-- > 0;) {
    if (variance(k) >= variance(best))
      best = k;
    else if (k == 0 || variance(k - 1) < variance(best))
      break;
  }
  return best;
}

void Emva::choose_patterns() {
  const auto is_large = [](const EmvaStack& s) { return s.light > 0.0 && !s.is_pair(); };
  const bool large = std::any_of(stacks_.begin(), stacks_.end(), is_large);
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < stacks_.size(); ++i) {
    const EmvaLevel one{i, dark_of(i)};
    if (stacks_[i].light == 0.0 || is_large(stacks_[i]) != large || one.dark == stacks_.size()) continue;
    const double away = std::abs(one.signal(stacks_) - 0.5 * levels_[saturation_].signal(stacks_));
    if (away < nearest) patterns_ = one;
    nearest = std::min(nearest, away);
  }
  if (!patterns_) return;
  const auto name = [](const EmvaStack& s) { return s.name + " of " + significant(s.squares.frames, 9) + " frames"; };
  result_.patterns = name(stacks_[patterns_->bright]) + ", " + name(stacks_[patterns_->dark]);
}

/// `shift` of the light of saturation, in the distance between the middles to the levels beside it. NaN where there is
/// no number.
EmvaValues Emva::values_of(const EmvaStacks& stacks, std::size_t saturation, double shift) const {
  EmvaValues v;
  v.fill(std::numeric_limits<double>::quiet_NaN());
  const auto light = [&](std::size_t k) { return stacks[levels_[k].bright].light; };
  const double full = levels_[saturation].signal(stacks);
  double uu = 0.0, uv = 0.0, pp = 0.0, pu = 0.0;
  std::size_t linear = 0, first = levels_.size(), last = 0;
  for (std::size_t k = 0; k < levels_.size(); ++k) {
    const double signal = levels_[k].signal(stacks);
    if (signal <= 0.7 * full) linear = k + 1;
    if (signal >= 0.05 * full) first = std::min(first, k);
    if (signal <= 0.95 * full) last = k + 1;
  }
  for (std::size_t k = 0; k < linear; ++k) {
    const double signal = levels_[k].signal(stacks);
    uu += square(signal);
    uv += signal * (stacks[levels_[k].bright].variance() - stacks[levels_[k].dark].variance());
    pp += square(light(k));
    pu += light(k) * signal;
  }
  const double K = v[kGain] = uv / uu, R = v[kResponsivity] = pu / pp;

  std::vector<double> times, means, variances;
  for (const std::size_t i : dark_) {
    times.push_back(stacks[i].time_s);
    means.push_back(stacks[i].mean);
    variances.push_back(stacks[i].variance());
  }
  double dark = variances.front();
  if (options_.counts_time && std::set<double>(times.begin(), times.end()).size() > 2) {
    const std::vector<double> ones(times.size(), 1.0);
    const EmvaLine line = line_of(times, variances, ones);
    dark = line.offset;
    v[kDarkMean] = line_of(times, means, ones).slope / K;
    v[kDarkVariance] = line.slope / (K * K);
  }
  v[kDarkNoise] = std::sqrt(std::max(kFloor, dark));
  v[kReadNoise] = std::sqrt(std::max(kFloor, dark) - 1.0 / 12.0) / K;
  v[kMinElectrons] = v[kDarkNoise] / K + 0.5;
  const std::size_t before = saturation > 0 ? saturation - 1 : 0, after = std::min(saturation + 1, levels_.size() - 1);
  const double most = light(saturation) + shift * (light(after) - light(before)) / static_cast<double>(after - before);
  v[kSatElectrons] = R / K * most;
  v[kRange] = v[kSatElectrons] / v[kMinElectrons];
  v[kRangeDb] = 20.0 * std::log10(v[kRange]);
  v[kSnr] = std::sqrt(v[kSatElectrons]);
  v[kSnrDb] = 20.0 * std::log10(v[kSnr]);
  if (counts_photons_) {
    v[kQuantum] = 100.0 * R / K;
    v[kMinPhotons] = v[kMinElectrons] * K / R;
    v[kSatPhotons] = most;
  }

  if (first + 3 <= last) {
    std::vector<double> x, y, weight, deviation;
    for (std::size_t k = first; k < last; ++k) {
      x.push_back(light(k));
      y.push_back(levels_[k].signal(stacks));
      weight.push_back(1.0 / square(y.back()));
    }
    const EmvaLine line = line_of(x, y, weight);
    for (std::size_t i = 0; i < x.size(); ++i)
      deviation.push_back(100.0 * (y[i] / (line.slope * x[i] + line.offset) - 1.0));
    v[kLinearMin] = *std::min_element(deviation.begin(), deviation.end());
    v[kLinearMax] = *std::max_element(deviation.begin(), deviation.end());
  }
  if (!patterns_) return v;
  const std::array<double, 4> lit = spatial(stacks[patterns_->bright]), unlit = spatial(stacks[patterns_->dark]);
  for (std::size_t k = 0; k < 4; ++k) {
    v[kDsnu + k] = unlit[k] / (K * K);
    v[kPrnu + k] = 1e4 * (lit[k] - unlit[k]) / square(patterns_->signal(stacks));
  }
  return v;
}

/// Standard deviations, of the patterns those of the squares.
EmvaValues Emva::spread_of(const EmvaValues& values) const {
  constexpr int kDraws = 1000;
  std::mt19937_64 bits(1);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> between(-0.5, 0.5);
  EmvaValues sum{}, squares{}, sd{}, count{};
  for (int draw = 0; draw < kDraws; ++draw) {
    EmvaStacks drawn = stacks_;
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      EmvaStack& one = drawn[i];
      const MeanSquares& s = stacks_[i].squares;
      const double v = s.value[kTvh];
      double mean_variance = std::max(v, s.value[kTv] + s.value[kTh] - v) / (s.frames * s.rows * s.columns);
      double light_sd = options_.light_repeatability, dof = s.dof(kTvh);
      if (const int k = joint_.level_of[i]; k >= 0) {  // which knows of flicker, and of neighbours that share noise
        const TransferLevel& level = joint_.levels[static_cast<std::size_t>(k)];
        mean_variance = level.mean_variance;
        light_sd = level.light_sd;
        dof = level.variance_sd > 0.0 ? std::min(level.dof, 2.0 * square(v / level.variance_sd)) : level.dof;
      }
      const std::size_t dark = stacks_[i].light > 0.0 ? dark_of(i) : stacks_.size();
      if (dark < stacks_.size()) {
        const double error = light_sd * normal(bits);
        one.mean += error * (stacks_[i].mean - stacks_[dark].mean);
        one.squares.value[kTvh] += error * std::max(0.0, v - stacks_[dark].squares.value[kTvh]);
      }
      one.mean += std::sqrt(mean_variance) * normal(bits);
      for (std::size_t part = 0; part < radiometry::kCubeParts; ++part) {
        const double of_part = part == kTvh ? dof : s.dof(part);
        one.squares.value[part] *= std::gamma_distribution<double>(0.5 * of_part, 2.0 / of_part)(bits);
      }
    }
    const EmvaValues one = values_of(drawn, saturation_of(drawn), between(bits));
    for (std::size_t place = 0; place < kEmvaPlaces; ++place) {
      const double away = one[place] - values[place];
      if (!std::isfinite(away)) continue;
      sum[place] += away;
      squares[place] += away * away;
      count[place] += 1.0;
    }
  }
  for (std::size_t place = 0; place < kEmvaPlaces; ++place)
    if (const double n = count[place]; n > 0.0)
      sd[place] = std::sqrt(std::max(0.0, squares[place] / n - square(sum[place] / n)));
  return sd;
}

void Emva::add_numbers() {
  const EmvaValues values = values_of(stacks_, saturation_, 0.0);
  if (std::isnan(values[kGain]))
    throw mtf::UsageError("no level lies below 70 % of the signal at saturation; give stacks with less light");
  const EmvaValues sds = spread_of(values);
  for (std::size_t place = 0; place < kEmvaPlaces; ++place) {
    const auto& [name, unit, from] = kTexts[place];
    const bool is_square = place >= kDsnu;
    const double value = values[place], sd = sds[place];
    const auto shown = [&](double x) { return is_square ? std::sqrt(std::max(0.0, x)) : x; };
    Finding f{.name = std::string(name), .unit = std::string(unit), .value = shown(value)};
    f.sd = is_square ? sd / (2.0 * f.value) : sd;
    f.low95 = shown(value - k95_sd * sd);
    f.high95 = shown(value + k95_sd * sd);
    f.from = from;
    if (place == kResponsivity && !counts_photons_) f.unit = "DN per unit of light";
    if (std::isnan(value))
      f.why = place == kDarkMean || place == kDarkVariance ? "it takes dark stacks of three exposures"
              : place == kLinearMin || place == kLinearMax ? "it takes three levels from 5 to 95 % of saturation"
              : is_square ? "it takes a dark stack of the exposure of the one with light"
                          : "the light of the stacks is not in photons";
    else if (value <= 0.0 && (is_square || place == kDarkVariance))
      f.why = (is_square ? "its variance is negative, " : "the dark variance falls with the exposure, ") +
              significant(value, 3) + " +- " + significant(sd, 2) + " " + f.unit + (is_square ? "^2" : "");
    if (!f.why.empty()) f.verdict = Verdict::not_determined;
    result_.numbers.push_back({.finding = std::move(f)});
  }
}

std::string percent_of(double x) { return significant(100.0 * x, std::abs(x) < 1.0 ? 2 : 3) + " %"; }
std::string percent_off(double bias) { return percent_of(std::abs(bias)) + (bias < 0.0 ? " low" : " high"); }

void Emva::add_notes() {
  std::string& saturation = result_.numbers[kSatPhotons].note;
  if (saturation_ + 1 < levels_.size()) {
    saturation =
        "a level of the series, the next has " + significant(stacks_[levels_[saturation_ + 1].bright].light, 6) + " p";
  } else {
    saturation = "the variance still rises at the brightest level: saturation is not reached";
    result_.warnings.push_back(saturation);
  }
  const std::size_t worst = *std::max_element(dark_.begin(), dark_.end(), [&](std::size_t a, std::size_t b) {
    return stacks_[a].clipped_low < stacks_[b].clipped_low;
  });
  if (const double share = stacks_[worst].clipped_low; share > 0.0)
    result_.warnings.push_back(stacks_[worst].name + ": " + significant(100.0 * share, 3) +
                               " % of the dark values are at the lower end of the scale, which lowers dark noise");
  if (result_.numbers[kDarkNoise].finding.value == std::sqrt(kFloor))
    result_.numbers[kDarkNoise].note = "the floor of 0.24 DN^2; rounding hides what is below";
  // A gain that is not to be trusted cancels in counts; the response that PRNU rests on does not.
  const double gain = 1.0 / joint_.find("electrons_per_count")->value;
  const double by_gain = joint_.misfit ? gain / result_.numbers[kGain].finding.value : 1.0;
  note_pattern(kDsnu, {"dsnu", "fixed_row", "fixed_column"}, by_gain);
  note_pattern(kDsnu + 1, {"fixed_row"}, by_gain);
  note_pattern(kDsnu + 2, {"fixed_column"}, by_gain);
  note_pattern(kDsnu + 3, {"dsnu"}, by_gain);
  if (joint_.misfit) return;
  note_pattern(kPrnu, {"prnu", "prnu_row", "prnu_column"}, 100.0);
  note_pattern(kPrnu + 1, {"prnu_row"}, 100.0);
  note_pattern(kPrnu + 2, {"prnu_column"}, 100.0);
  note_pattern(kPrnu + 3, {"prnu"}, 100.0);
  note_biases();
}

/// The joint fit's parts of a pattern, times the factor, beside the standard's number.
void Emva::note_pattern(std::size_t place, const std::vector<const char*>& parts, double factor) {
  auto& [finding, bias, note] = result_.numbers[place];
  double squares = 0.0, most = 0.0;
  bool is_there = false;
  for (const char* const part : parts) {
    const Finding* f = joint_.find(part);
    if (f == nullptr || f->verdict == Verdict::not_determined) return;
    squares += square(factor * f->value);
    most += square(factor * f->high95);
    is_there = is_there || f->verdict == Verdict::determined;
  }
  const bool is_stated = finding.verdict == Verdict::determined;
  const double fixed = std::sqrt(squares);
  if (is_there && is_stated) bias = finding.value / fixed - 1.0;
  if (is_stated && std::abs(finding.value - fixed) < finding.sd) return;
  note = (bias ? percent_off(*bias) + ": " : "") + "the fixed part is " +
         (is_there ? significant(fixed, 3) + " " + finding.unit
                   : "0 .. " + significant(std::sqrt(most), 3) + " " + finding.unit + " (95 %)");
}

/// The definitions for the model of the joint fit, at the stated light, over what the model has.
void Emva::note_biases() {
  const PhotonTransfer& t = joint_.transfer;
  EmvaStacks model = stacks_;
  for (std::size_t i = 0; i < stacks_.size(); ++i) {
    if (joint_.level_of[i] < 0) continue;
    const PhotonTransfer::Level level = level_at(t, stacks_[i].light, stacks_[i].time_s);
    model[i].mean = level.mean;
    model[i].squares.value.fill(level.variance);
  }
  double fitted = 1.0;  // all levels below that share of saturation are in the fit
  for (const EmvaLevel& level : levels_)
    if (joint_.level_of[level.bright] < 0 || joint_.level_of[level.dark] < 0)
      fitted = std::min(fitted, level.signal(stacks_) / levels_[saturation_].signal(stacks_));
  if (fitted <= 0.7) {
    result_.biases += "; none of K and what rests on it, as stacks below 70 % of saturation are clipped";
    return;
  }
  const EmvaValues of_model = values_of(model, saturation_, 0.0);
  const auto state = [&](std::size_t place, double truth, const std::string& cause) {
    auto& [finding, bias, note] = result_.numbers[place];
    if (finding.verdict != Verdict::determined || !(truth > 0.0)) return;
    bias = of_model[place] / truth - 1.0;
    if (std::abs(*bias * finding.value) > finding.sd) note = percent_off(*bias) + cause;
  };
  const double gain = 1.0 / joint_.find("electrons_per_count")->value, rate = joint_.find("rate")->value;
  const std::vector<std::string> terms(t.names.begin() + 4, t.names.begin() + 4 + std::ssize(t.a));
  const std::string bends = " (" + mtf::joined(terms) + ")";
  std::vector<std::string> causes;
  if (!t.a.empty())
    causes.push_back("the response bends" + bends + " " + percent_of(of_model[kGain] / t.gain.value - 1.0));
  if (joint_.crosstalk.found) causes.push_back("crosstalk " + percent_of(joint_.crosstalk.power.value - 1.0));
  state(kGain, gain, ": " + mtf::joined(causes));
  state(kResponsivity, rate * gain, ": the response bends" + bends);
  const std::string by_gain = ", as K is off";
  state(kQuantum, 100.0 * rate, by_gain);
  state(kSatElectrons, rate * stacks_[levels_[saturation_].bright].light, by_gain);
  if (const Finding* read = joint_.find("read_noise"); read->verdict == Verdict::determined) {
    const double floor = of_model[kReadNoise] * of_model[kGain] / (read->value * gain) - 1.0;
    state(kReadNoise, read->value,
          floor > 1e-3 ? ": the floor and 1/12 " + percent_of(floor) + ", the rest by K" : by_gain);
  }
  if (const Finding* dark = joint_.find("dark_current"); dark->verdict == Verdict::determined)
    state(kDarkMean, dark->value, by_gain);
  if (fitted <= 0.95) return;
  for (const EmvaPlace place : {kLinearMin, kLinearMax})
    if (result_.numbers[place].finding.why.empty())
      result_.numbers[place].note =
          (t.a.empty() ? "the fitted response has none"
                       : "the fitted response has " + significant(of_model[place], 2) + " %") +
          std::string("; noise and the lamp make the rest");
}

}  // namespace

const EmvaNumber* Emva1288::find(std::string_view name) const {
  const auto found =
      std::find_if(numbers.begin(), numbers.end(), [&](const EmvaNumber& n) { return n.finding.name == name; });
  return found == numbers.end() ? nullptr : &*found;
}

Emva1288 emva1288(std::vector<Stack> stacks, const CharacterizeOptions& options, bool counts_photons) {
  return Emva(std::move(stacks), options, counts_photons).take();
}

}  // namespace calib
