// SPDX-License-Identifier: Apache-2.0
#include "mtf/sample.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "mtf/error.h"
#include "mtf/special.h"

namespace mtf {
namespace {

// 1/A up to the limit g, then g^2 A: continuous at |A| = 1/g, and no frequency is amplified more than g.
double limited_inverse(double a, double limit) { return std::abs(a) * limit >= 1.0 ? 1.0 / a : limit * limit * a; }

constexpr int kMostWavelengths = 512;

// About 30 ns a value (tests/bench/bench_components): vectors and tables are short, the rest is evaluated everywhere.
double saved_ms(const Traits& traits, std::int64_t samples) {
  const auto count = static_cast<double>(samples);
  return 30e-6 * (traits.separable ? 2.0 * std::sqrt(count) : traits.radial ? std::min(count, 2048.0) : count);
}

std::string join_labels(const std::vector<const Entry<double>*>& entries) {
  std::string text;
  for (const Entry<double>* entry : entries) text += (text.empty() ? "" : ", ") + entry->label;
  return text;
}

}  // namespace

OtfSampler::OtfSampler(const System<double>& system, std::span<const Stage> stages, const SceneAperture& aperture,
                       const SamplerOptions& options)
    : system_(system), aperture_(aperture), stages_(stages.begin(), stages.end()), options_(options) {
  const double target = std::clamp(options.table_share, 1e-7, 1e-6);
  if (aperture_.kind == SceneAperture::Kind::curve && aperture_.curve->unit->name == "cy/px" &&
      system_.frame.pitch_x_um != system_.frame.pitch_y_um)
    throw UsageError(
        "scene.aperture: a curve in cy/px has no one meaning with pixels that are not square; give it in cy/mm");
  bound_correction();
  sort_components();

  // A radial table ends where all of its components do; what others cut off is not its concern.
  const Context<double> shortest = system_.band ? system_.context(system_.band->lo_um) : system_.context();
  const auto end_of = [&](std::initializer_list<const std::vector<const Entry<double>*>*> lists) {
    double end = std::hypot(options.fx_max, options.fy_max);
    for (const auto* list : lists)
      for (const Entry<double>* entry : *list) end = std::min(end, entry->component.cutoff_cy_mm(shortest));
    return end;
  };
  for (const Entry<double>* entry : entries_) cutoff_ = std::min(cutoff_, entry->component.cutoff_cy_mm(shortest));
  const auto& chromatic = chromatic_general_.empty() ? chromatic_radial_ : chromatic_general_;
  // Slow components are given what they may err by, not the least that a table can.
  const double slow_target = std::clamp(4.0 * options.table_share, 1e-7, 1e-4);
  if (!chromatic.empty()) {
    // Slow ones are tabulated by other means, and these values say how well.
    choose_wavelengths(end_of({&chromatic}), chromatic_general_.empty() ? target : 0.05 * slow_target);
    if (chromatic_general_.empty()) tabulate_band(end_of({&chromatic}));
  }

  const bool aperture_radial = aperture_.kind == SceneAperture::Kind::curve || !options.split.is_whole();
  if (!radial_.empty() || !chromatic_radial_.empty() || aperture_radial) {
    if (options.table_share > 0.0)
      table_.emplace(
          [this](std::span<const double> radius, std::span<double> value) {
            for (std::size_t i = 0; i < radius.size(); ++i) value[i] = radial_product(radius[i]);
          },
          end_of({&radial_, &chromatic_radial_}), target, std::min(options.samples, RadialTable::kMostSamples));
    std::string names = join_labels(radial_);
    if (!chromatic_radial_.empty()) names += (names.empty() ? "" : ", ") + join_labels(chromatic_radial_);
    if (!table_ || table_->error() > 20.0 * options.table_share) {
      // Steep or kinked beyond what a table resolves (a thin annulus, a ragged curve): exact, and slower.
      table_.reset();
      radial_per_sample_ = true;
    }
    if (!names.empty())
      merged_.push_back(names +
                        (table_ ? " -> one radial table" : " -> one radial factor, evaluated at every frequency"));
  }
  tabulate_lines(target);
  tabulate_slow(slow_target);
  if (!separable_.empty()) merged_.push_back(join_labels(separable_) + " -> one vector per axis");
}

// The limit may be met anywhere in the band: a box or a curve rises again behind its zeros.
void OtfSampler::bound_correction() {
  const double fx_max = options_.fx_max, fy_max = options_.fy_max;
  if (aperture_.kind == SceneAperture::Kind::point) return;
  constexpr int kSteps = 4096;
  const auto highest = [this](const auto& mtf, double end, double limit) {
    double least = 1.0;
    for (int i = 1; i <= kSteps; ++i) least = std::min(least, std::abs(mtf(end * static_cast<double>(i) / kSteps)));
    aperture_limited_ = aperture_limited_ || least * limit < 1.0;
    return least * limit < 1.0 ? limit : 1.0 / least;
  };
  const double limit = aperture_.gain_limit, root = std::sqrt(limit);
  correction_ = highest([this](double f) { return aperture_mtf(Axis::x, f); }, fx_max, root) *
                highest([this](double f) { return aperture_mtf(Axis::y, f); }, fy_max, root) *
                highest([this](double r) { return aperture_mtf(r); }, std::hypot(fx_max, fy_max), limit);
}

double OtfSampler::scene_cost(const Entry<double>& entry) const {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  if (!options_.scene || options_.scene->spectrum == nullptr) return kUnknown;
  const Component<double>& component = entry.component;
  // Pupils by quadrature cost more to sample than they would save.
  if (component.is_slow()) return kUnknown;
  constexpr int kCells = SceneSpectrum::kCells;
  std::vector<Freq<double>> f;
  const double cell_x = SceneSpectrum::corner_cy_mm(1, options_.fx_max);
  const double cell_y = SceneSpectrum::corner_cy_mm(1, options_.fy_max);
  for (int j = -kCells; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i) f.push_back({i * cell_x, j * cell_y});
  // One more in each of the cells on four lines through the half-plane, at irregular places.
  std::vector<std::size_t> corner_of;
  for (int line = 0; line < 4; ++line)
    for (int i = 0; i < kCells; ++i) {
      const int j = std::array{0, i, -1 - i, kCells / 2}[static_cast<std::size_t>(line)];
      const double jitter = std::fmod(0.381966011250105 + 0.618033988749895 * static_cast<double>(4 * i + line), 1.0);
      f.push_back({(i + jitter) * cell_x, (j + 1.0 - jitter) * cell_y});
      corner_of.push_back(static_cast<std::size_t>((j + kCells) * SceneSpectrum::kColumns + i));
    }
  std::vector<double> error(f.size(), 0.0);
  const auto visit = [&](const Context<double>& ctx) {
    std::vector<Complex<double>> h(f.size(), {1.0, 0.0});
    component.multiply(f, ctx, h);
    for (std::size_t i = 0; i < h.size(); ++i) error[i] = std::max(error[i], std::hypot(h[i].re - 1.0, h[i].im));
  };
  if (system_.band && component.traits(system_.context()).chromatic) {
    visit(system_.context(system_.band->lo_um));
    visit(system_.context(system_.band->hi_um));
  } else {
    visit(system_.context());
  }
  // Where it turns faster than the corners can show, they say nothing.
  const std::size_t corners = error.size() - corner_of.size();
  for (std::size_t p = 0; p < corner_of.size(); ++p) {
    const double* corner = error.data() + corner_of[p];
    const double about =
        std::max({corner[0], corner[1], corner[SceneSpectrum::kColumns], corner[SceneSpectrum::kColumns + 1]});
    if (error[corners + p] > 1.5 * about + 1e-9) return kUnknown;
  }
  const SceneCost& scene = *options_.scene;
  return scene.scale * scene.spectrum->rms_error(error, scene.ratio_x, scene.ratio_y);
}

void OtfSampler::sort_components() {
  const Context<double> ctx = system_.context();
  struct Candidate {
    const Entry<double>* entry;
    double deviation;  ///< bound of |otf - 1|
    double cost;       ///< what it costs to leave out
  };
  std::vector<Candidate> candidates;
  for (const Stage stage : stages_)
    for (const Entry<double>& entry : system_.list(stage)) {
      // A chromatic deviation is largest at one end of the band.
      double deviation = entry.component.deviation(options_.fx_max, options_.fy_max, ctx);
      if (system_.band)
        for (const double wavelength : {system_.band->lo_um, system_.band->hi_um})
          deviation = std::max(
              deviation, entry.component.deviation(options_.fx_max, options_.fy_max, system_.context(wavelength)));
      candidates.push_back({&entry, deviation, std::min(deviation, scene_cost(entry))});
    }
  // What is left out would have been multiplied by the components that amplify.
  double amplified = correction_;
  for (const Candidate& candidate : candidates) {
    if (candidate.entry->component.traits(ctx).gain) amplified *= 1.0 + candidate.deviation;
    identity_error_ += candidate.cost;
  }
  const double budget = options_.drop_budget / amplified;
  identity_error_ *= amplified;
  std::vector<std::size_t> order(candidates.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return candidates[a].cost < candidates[b].cost; });
  std::vector<bool> drop(candidates.size());
  double spent = 0.0;
  for (const std::size_t i : order) {
    if (spent + candidates[i].cost > budget) break;
    spent += candidates[i].cost;
    drop[i] = true;
  }
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Entry<double>* entry = candidates[i].entry;
    const Traits traits = entry->component.traits(ctx);
    if (drop[i]) {
      dropped_.push_back({entry->label, candidates[i].cost, saved_ms(traits, options_.samples)});
      continue;
    }
    const bool chromatic = system_.band && traits.chromatic;
    real_ = real_ && traits.real;
    even_x_ = even_x_ && traits.even_x;
    even_y_ = even_y_ && traits.even_y;
    if (traits.gain) gain_ *= 1.0 + candidates[i].deviation;
    entries_.push_back(entry);
    auto& list = chromatic          ? (traits.radial ? chromatic_radial_ : chromatic_general_)
                 : traits.separable ? separable_
                 : traits.radial    ? radial_
                                    : general_;
    list.push_back(entry);
  }
  if (chromatic_general_.empty()) return;
  // The product over wavelengths is averaged as one: a single non-radial factor takes the radial ones along.
  chromatic_general_.insert(chromatic_general_.end(), chromatic_radial_.begin(), chromatic_radial_.end());
  chromatic_radial_.clear();
}

// Motion along one direction depends on f.u alone, an even function where it is real. A table that is too coarse for it
// leaves the component where it is.
void OtfSampler::tabulate_lines(double target) {
  if (!(options_.table_share > 0.0)) return;
  const Context<double> ctx = system_.context();
  std::erase_if(general_, [&](const Entry<double>* entry) {
    const auto u = entry->component.line(ctx);
    if (!u || !entry->component.traits(ctx).real) return false;
    RadialTable table(
        [&](std::span<const double> radius, std::span<double> value) {
          for (std::size_t i = 0; i < radius.size(); ++i)
            value[i] = entry->component.otf({u->x * radius[i], u->y * radius[i]}, ctx).re;
        },
        std::abs(u->x) * options_.fx_max + std::abs(u->y) * options_.fy_max, target,
        std::min(options_.samples, RadialTable::kMostSamples));
    if (table.line_error() > 20.0 * options_.table_share) return false;
    lines_.push_back({*u, std::move(table)});
    merged_.push_back(entry->label + " -> one table along its direction");
    return true;
  });
}

// Aberrated pupils: microseconds a sample, but smooth between a few radii. A band averages the whole chromatic product.
void OtfSampler::tabulate_slow(double target) {
  // About what a table evaluates at least, and the most it may: what is rougher is no better off with one.
  constexpr std::int64_t kWorthIt = 4000, kMostEvaluations = 40000;
  if (!(options_.table_share > 0.0) || options_.samples < kWorthIt) return;
  const double end = std::hypot(options_.fx_max, options_.fy_max) * (1.0 + 1e-9);  // the corner itself lies within
  const auto add_kinks = [&](const Entry<double>* entry, const Context<double>& ctx, std::vector<double>& breaks) {
    for (const double r : entry->component.kinks_cy_mm(ctx)) breaks.push_back(std::min(r, end));
  };
  const auto tabulate = [&](const PolarTable::Function& h, const PolarTable::Rings& rings, std::vector<double> breaks,
                            std::int64_t most, const std::string& names) {
    std::sort(breaks.begin(), breaks.end());
    PolarTable table(h, rings, std::move(breaks), target, most, options_.threads);
    if (table.error() > 20.0 * options_.table_share) return false;
    polar_.push_back(std::move(table));
    merged_.push_back(names + " -> one table over radius and direction");
    return true;
  };
  const std::int64_t most = std::min(options_.samples, kMostEvaluations);
  const Context<double> ctx = system_.context();
  std::erase_if(general_, [&](const Entry<double>* entry) {
    if (!entry->component.is_slow()) return false;
    std::vector<double> breaks;
    add_kinks(entry, ctx, breaks);
    const PolarTable::Function h = [&](const Freq<double>& f) { return entry->component.otf(f, ctx); };
    return tabulate(h, reported(PolarTable::rings_of(h, options_.threads)), std::move(breaks), most, entry->label);
  });
  if (chromatic_general_.empty()) return;
  std::vector<double> breaks;
  for (const Entry<double>* entry : chromatic_general_)
    for (const double wavelength : {system_.band->lo_um, system_.band->hi_um})
      add_kinks(entry, system_.context(wavelength), breaks);
  // Values at single wavelengths are shared by all frequencies, and the table of the band is smoother.
  constexpr std::int64_t kWavelengths = 16;
  const PolarTable::Function h = [this](const Freq<double>& f) { return chromatic_product(f); };
  const bool fixed = options_.wavelengths > 0;
  const PolarTable::Rings rings = fixed ? reported(PolarTable::rings_of(h, options_.threads)) : band_rings(end, target);
  if (tabulate(h, rings, std::move(breaks), fixed ? most : kWavelengths * most, join_labels(chromatic_general_)))
    chromatic_general_.clear();
}

PolarTable::Rings OtfSampler::reported(PolarTable::Rings rings) const {
  return [this, rings = std::move(rings)](std::span<const double> r, std::size_t spokes,
                                          std::span<std::complex<double>> rows) {
    const std::int64_t values = rings(r, spokes, rows);
    if (options_.progress) options_.progress(values);
    return values;
  };
}

// The series around every ring at a few wavelengths, averaged over the band one by one.
PolarTable::Rings OtfSampler::band_rings(double end, double target) const {
  constexpr std::size_t kMostPanels = 64;
  const Band band = *system_.band;
  std::vector<double> breaks = chromatic_kinks();
  for (double& kink : breaks) kink /= band.hi_um;
  const bool ends = cutoff_ < std::numeric_limits<double>::infinity();
  struct Kept {
    std::size_t spokes = 0;
    std::optional<BandMean> mean;
  };
  return
      [this, band, breaks, ends, end, error = std::clamp(target / 64.0, 1e-9, 1e-7), kept = std::make_shared<Kept>()](
          std::span<const double> r, std::size_t spokes, std::span<std::complex<double>> rows) {
        std::int64_t values = 0;
        const std::size_t orders = spokes / 2;
        if (kept->spokes != spokes) {
          const auto p = [&](double wavelength_um, std::span<const double> t, std::span<double> numbers) {
            const PolarTable::Function h = [&](const Freq<double>& f) { return product_at(f, wavelength_um); };
            std::vector<std::complex<double>> series(t.size() * orders);
            values += reported(PolarTable::rings_of(h, options_.threads))(t, spokes, series);
            for (std::size_t i = 0; i < series.size(); ++i)
              numbers[2 * i] = series[i].real(), numbers[2 * i + 1] = series[i].imag();
          };
          kept->mean.emplace(p, 2 * orders, band, breaks, ends, end,
                             BandMean::Options{.exact = 2 * orders, .error = error, .panels = kMostPanels});
          kept->spokes = spokes;
        }
        std::vector<double> numbers(2 * orders);
        for (std::size_t i = 0; i < r.size(); ++i) {
          kept->mean->at(r[i], numbers);
          for (std::size_t m = 0; m < orders; ++m) rows[i * orders + m] = {numbers[2 * m], numbers[2 * m + 1]};
        }
        return values;
      };
}

// As those above, of slow components that depend on |f| alone.
void OtfSampler::tabulate_band(double end) {
  const bool slow = std::any_of(chromatic_radial_.begin(), chromatic_radial_.end(),
                                [](const Entry<double>* entry) { return entry->component.is_slow(); });
  if (!slow || !(options_.table_share > 0.0) || options_.wavelengths > 0) return;
  constexpr double kError = 1e-8;
  std::vector<double> breaks = chromatic_kinks();
  for (double& kink : breaks) kink /= system_.band->hi_um;
  const auto p = [this](double wavelength_um, std::span<const double> t, std::span<double> numbers) {
    if (options_.progress) options_.progress(static_cast<std::int64_t>(t.size()));
    for (std::size_t i = 0; i < t.size(); ++i) numbers[i] = product_at({t[i], 0.0}, wavelength_um).re;
  };
  radial_mean_.emplace(p, 1, *system_.band, std::move(breaks), true, end,
                       BandMean::Options{.exact = 1, .error = kError});
  constexpr int kProbes = 24;
  double worst = 0.0;
  for (int i = 0; i < kProbes; ++i) {
    const double r = end * (static_cast<double>(i) + 0.5) / kProbes;
    double mean = 0.0;
    radial_mean_->at(r, {&mean, 1});
    worst = std::max(worst, std::abs(mean - chromatic_product({r, 0.0}).re));
  }
  quadrature_error_ += 2.0 * worst;
}

Complex<double> OtfSampler::product_at(const Freq<double>& f, double wavelength_um) const {
  const auto& list = chromatic_general_.empty() ? chromatic_radial_ : chromatic_general_;
  const Context<double> ctx = system_.context(wavelength_um);
  Complex<double> product{1.0, 0.0};
  for (const Entry<double>* entry : list) product = product * entry->component.otf(f, ctx);
  return product;
}

Complex<double> OtfSampler::chromatic_product(const Freq<double>& f) const {
  WavelengthNodes own;
  const WavelengthNodes& nodes = wavelength_rule_.at(std::hypot(f.x, f.y), own);
  Complex<double> mean{};
  for (std::size_t w = 0; w < nodes.weight.size(); ++w)
    mean = mean + Complex<double>{nodes.weight[w], 0.0} * product_at(f, nodes.wavelength_um[w]);
  return mean;
}

std::vector<double> OtfSampler::chromatic_kinks() const {
  const Context<double> middle = system_.context();
  std::vector<double> kinks;
  for (const auto* list : {&chromatic_radial_, &chromatic_general_})
    for (const Entry<double>* entry : *list)
      for (const double f : entry->component.kinks_cy_mm(middle)) kinks.push_back(f * middle.wavelength_um);
  std::sort(kinks.begin(), kinks.end());
  return kinks;
}

void OtfSampler::choose_wavelengths(double end, double target) {
  // A radial product is the same in all directions; others are sampled in a few, less closely.
  const bool radial = chromatic_general_.empty(), fixed = options_.wavelengths > 0;
  const auto& list = radial ? chromatic_radial_ : chromatic_general_;
  const bool slow =
      std::any_of(list.begin(), list.end(), [](const Entry<double>* entry) { return entry->component.is_slow(); });
  const std::size_t directions = radial ? 1 : 4, radii = slow ? 8 : 128;
  const std::vector<double> kinks = fixed ? std::vector<double>{} : chromatic_kinks();
  const auto averages = [&](int n) {
    wavelength_rule_ = BandRule(*system_.band, kinks, n);
    std::vector<Complex<double>> mean(radii * directions);
    for (std::size_t i = 0; i < mean.size(); ++i) {
      const double r = end * (static_cast<double>(i / directions) + 0.5) / static_cast<double>(radii);
      const double a = 0.25 * static_cast<double>(i % directions);
      mean[i] = chromatic_product({r * cos_pi(a), r * sin_pi(a)});
    }
    return mean;
  };
  // A slow product takes the fewest that will do; for others the steps are wide.
  const auto next = [slow](int count) { return slow ? count + std::max(2, count / 2) : 2 * count; };
  int n = fixed ? options_.wavelengths : 4;
  std::vector<Complex<double>> coarse = averages(n);
  for (; n < kMostWavelengths || fixed; n = next(n)) {
    std::vector<Complex<double>> fine = averages(next(n));
    double worst = 0.0;
    for (std::size_t i = 0; i < fine.size(); ++i)
      worst = std::max(worst, std::hypot(fine[i].re - coarse[i].re, fine[i].im - coarse[i].im));
    quadrature_error_ = worst;
    if (worst <= target || fixed) break;
    coarse = std::move(fine);
  }
  wavelength_rule_ = BandRule(*system_.band, kinks, n);
  wavelengths_ = n;
}

double OtfSampler::radial_product(double r) const {
  const Freq<double> f{r, 0.0};
  double product = aperture_radial(r) * options_.split.factor(r);
  for (const Entry<double>* entry : radial_) product *= entry->component.otf(f, system_.context()).re;
  if (chromatic_radial_.empty()) return product;
  if (!radial_mean_) return product * chromatic_product(f).re;
  double mean = 0.0;
  radial_mean_->at(r, {&mean, 1});
  return product * mean;
}

double OtfSampler::aperture_mtf(Axis axis, double f) const {
  if (aperture_.kind != SceneAperture::Kind::box && aperture_.kind != SceneAperture::Kind::gaussian) return 1.0;
  const Frame<double>& frame = system_.frame;
  const double size_mm = 1e-3 * (axis == Axis::x ? aperture_.size.x_um(frame) : aperture_.size.y_um(frame));
  return aperture_.kind == SceneAperture::Kind::box ? sinc(size_mm * f).value : gaussian(size_mm * f).value;
}

double OtfSampler::aperture_mtf(double r) const {
  if (aperture_.kind != SceneAperture::Kind::curve) return 1.0;
  const std::string_view unit = aperture_.curve->unit->name;
  const double f = unit == "cy/mrad" ? system_.frame.cy_per_mrad(r)
                   : unit == "cy/px" ? system_.frame.cy_per_px(r, Axis::x)
                                     : r;
  return evaluate(*aperture_.curve, f).value;
}

double OtfSampler::aperture_factor(Axis axis, double f) const {
  return limited_inverse(aperture_mtf(axis, f), std::sqrt(aperture_.gain_limit));
}

double OtfSampler::aperture_radial(double r) const { return limited_inverse(aperture_mtf(r), aperture_.gain_limit); }

double OtfSampler::error() const {
  double sum = (table_ ? table_->error() : 0.0) + quadrature_error_;
  for (const Line& line : lines_) sum += line.table.line_error();
  for (const PolarTable& table : polar_) sum += table.error();
  for (const Dropped& dropped : dropped_) sum += dropped.bound;
  return sum * gain();
}

Complex<double> OtfSampler::at(const Freq<double>& f) const {
  const double correction = aperture_factor(Axis::x, f.x) * aperture_factor(Axis::y, f.y) *
                            aperture_radial(std::hypot(f.x, f.y)) * options_.split.factor(std::hypot(f.x, f.y));
  Complex<double> h{correction, 0.0};
  for (const Stage stage : stages_) h = h * system_.otf(stage, f);
  return h;
}

double OtfSampler::axis_bound(Axis axis, double f_cy_mm) const {
  if (std::abs(f_cy_mm) >= cutoff_) return 0.0;
  const Freq<double> f = axis == Axis::x ? Freq<double>{f_cy_mm, 0.0} : Freq<double>{0.0, f_cy_mm};
  Complex<double> h{aperture_factor(axis, f_cy_mm), 0.0};
  for (const Entry<double>* entry : separable_) h = h * entry->component.otf(f, system_.context());
  const double radial = table_ ? table_->bound_from(std::abs(f_cy_mm))
                               : std::max(1.0, options_.split.factor(std::hypot(options_.fx_max, options_.fy_max)));
  return std::hypot(h.re, h.im) * radial * gain();
}

}  // namespace mtf
