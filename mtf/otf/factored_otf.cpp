// SPDX-License-Identifier: Apache-2.0
#include "mtf/otf/factored_otf.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "mtf/error.h"
#include "mtf/math/special.h"
#include "mtf/otf/same_list.h"
#include "mtf/words.h"

namespace mtf {
namespace {

// 1/A up to the limit g, then g^2 A: continuous at |A| = 1/g, and no frequency is amplified more than g.
double limited_inverse(double a, double limit) { return std::abs(a) * limit >= 1.0 ? 1.0 / a : limit * limit * a; }

// About 30 ns a value (tests/bench/bench_components): vectors and tables are short, the rest is evaluated everywhere.
double saved_ms(const Traits& traits, std::int64_t samples) {
  const auto count = static_cast<double>(samples);
  return 30e-6 * (traits.separable ? 2.0 * std::sqrt(count) : traits.radial ? std::min(count, 2048.0) : count);
}

}  // namespace

std::string FactoredOtf::join_labels(const Entries& entries) {
  return joined(entries, [](const Entry<double>* entry) { return entry->label; });
}

FactoredOtf::FactoredOtf(const System<double>& system, std::span<const Stage> stages, const SceneAperture& aperture,
                         const SamplerOptions& options, const FactoredOtf* earlier)
    : system_(system), aperture_(aperture), stages_(stages.begin(), stages.end()), options_(options) {
  const double target = std::clamp(options.table_share, 1e-7, 1e-6);
  if (aperture_.kind == SceneAperture::Kind::curve && aperture_.curve->unit->name == "cy/px" &&
      system_.frame.pitch_x_um != system_.frame.pitch_y_um)
    throw UsageError(
        "scene.aperture: a curve in cy/px has no one meaning with pixels that are not square; give it in cy/mm");
  bound_correction();
  sort_components();

  // A radial table ends where all of its components do; where others end does not matter to it.
  const Context<double> shortest = system_.band ? system_.context(system_.band->lo_um) : system_.context();
  const auto end_of = [&](std::initializer_list<const std::vector<const Entry<double>*>*> lists) {
    double end = std::hypot(options.fx_max, options.fy_max);
    for (const auto* list : lists)
      for (const Entry<double>* entry : *list) end = std::min(end, entry->component.cutoff_cy_mm(shortest));
    return end;
  };
  for (const Entry<double>* entry : entries_) cutoff_ = std::min(cutoff_, entry->component.cutoff_cy_mm(shortest));
  averaged_ = chromatic_general_.empty() ? chromatic_radial_ : chromatic_general_;
  if (earlier != nullptr && !asks_for_same_tables(*earlier)) earlier = nullptr;
  // Slow components are given the error that they may have, not the smallest that a table can keep.
  const double slow_target = std::clamp(4.0 * options.table_share, 1e-7, 1e-4);
  const bool same_average = earlier != nullptr && same_components(averaged_, earlier->averaged_);
  if (same_average) {
    wavelength_rule_ = earlier->wavelength_rule_;
    wavelengths_ = earlier->wavelengths_;
    quadrature_error_ = earlier->quadrature_error_;
  } else if (!averaged_.empty()) {
    // Slow ones are tabulated by other means, and these values say how well.
    choose_wavelengths(end_of({&averaged_}), chromatic_general_.empty() ? target : 0.05 * slow_target);
  }
  if (same_average && earlier->table_ && same_components(radial_, earlier->radial_)) {
    table_ = earlier->table_;
    mean_error_ = earlier->mean_error_;
    if (const std::string names = radial_labels(); !names.empty()) merged_.push_back(names + " -> one radial table");
  } else {
    if (!chromatic_radial_.empty()) tabulate_band(end_of({&chromatic_radial_}));
    tabulate_radial(end_of({&radial_, &chromatic_radial_}), target);
  }
  tabulate_lines(target);
  tabulate_slow(slow_target, earlier);
  if (!separable_.empty()) merged_.push_back(join_labels(separable_) + " -> one vector per axis");
}

std::string FactoredOtf::radial_labels() const {
  std::string names = join_labels(radial_);
  if (!chromatic_radial_.empty()) names += (names.empty() ? "" : ", ") + join_labels(chromatic_radial_);
  return names;
}

void FactoredOtf::tabulate_radial(double end, double target) {
  const bool aperture_radial = aperture_.kind == SceneAperture::Kind::curve || !options_.split.is_whole();
  if (radial_.empty() && chromatic_radial_.empty() && !aperture_radial) return;
  if (options_.table_share > 0.0)
    table_ = std::make_shared<const RadialTable>(
        [this](std::span<const double> radius, std::span<double> value) {
          for_each(radius.size(), [&](std::size_t i) { value[i] = radial_product(radius[i]); });
        },
        end, target, std::min(options_.samples, RadialTable::kMostSamples));
  if (!table_ || table_->error() > 20.0 * options_.table_share) {
    // Steep or kinked beyond what a table resolves (a thin annulus, a ragged curve): exact, and slower.
    table_.reset();
    radial_per_sample_ = true;
  }
  if (const std::string names = radial_labels(); !names.empty())
    merged_.push_back(names +
                      (table_ ? " -> one radial table" : " -> one radial factor, evaluated at every frequency"));
}

bool FactoredOtf::same_components(const Entries& a, const Entries& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto* x, const auto* y) { return same_component(x->component, y->component); });
}

bool FactoredOtf::asks_for_same_tables(const FactoredOtf& other) const {
  const auto asked = [](const SamplerOptions& o) {
    return std::tie(o.fx_max, o.fy_max, o.table_share, o.wavelengths, o.samples, o.split);
  };
  return asked(options_) == asked(other.options_) && aperture_.kind != SceneAperture::Kind::curve &&
         other.aperture_.kind != SceneAperture::Kind::curve && same_surroundings(system_, other.system_);
}

// The limit may be exceeded anywhere in the band: a box or a curve rises again after its zeros.
void FactoredOtf::bound_correction() {
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

double FactoredOtf::scene_cost(const Entry<double>& entry) const {
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
  // One more sample in each of the cells on four lines through the half-plane, at irregular places.
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
  // Where the OTF turns faster than the corners can show, their values say nothing.
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

void FactoredOtf::sort_components() {
  const Context<double> ctx = system_.context();
  struct Candidate {
    const Entry<double>* entry;
    double deviation;  ///< bound of |otf - 1|
    double cost;       ///< what it costs to leave out
  };
  std::vector<Candidate> candidates;
  for (const Stage stage : stages_)
    for (std::size_t i = 0; i < system_.list(stage).size(); ++i) {
      const Entry<double>& entry = system_.list(stage)[i];
      if (is_given(stage, i)) continue;
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
    const Parities parities(traits.real, traits.even_x, traits.even_y);
    if (drop[i]) {
      dropped_parities_ = dropped_parities_ * parities;
      dropped_.push_back({entry->label, candidates[i].cost, saved_ms(traits, options_.samples)});
      continue;
    }
    const bool chromatic = system_.band && traits.chromatic;
    parities_ = parities_ * parities;
    if (traits.gain) gain_ *= 1.0 + candidates[i].deviation;
    entries_.push_back(entry);
    auto& list = chromatic          ? (traits.radial ? chromatic_radial_ : chromatic_general_)
                 : traits.separable ? separable_
                 : traits.radial    ? radial_
                                    : general_;
    list.push_back(entry);
  }
  all_parities_ = parities_;
  take_given();
  if (chromatic_general_.empty()) return;
  // The product over wavelengths is averaged as one: a single non-radial factor takes the radial ones along.
  chromatic_general_.insert(chromatic_general_.end(), chromatic_radial_.begin(), chromatic_radial_.end());
  chromatic_radial_.clear();
}

bool FactoredOtf::is_given(Stage stage, std::size_t entry) const {
  if (stage != Stage::presample || !options_.given) return false;
  const std::vector<std::size_t>& entries = options_.given->entries;
  return std::find(entries.begin(), entries.end(), entry) != entries.end();
}

void FactoredOtf::take_given() {
  if (!options_.given) return;
  const GivenFactor& given = *options_.given;
  all_parities_ = parities_ * given.all;
  parities_ = parities_ * given.parities;
  gain_ *= given.largest;
  identity_error_ += 2.0;  // it is always needed
  cutoff_ = given.cutoff_cy_mm;
  polar_.push_back({{}, given.table});
}

double FactoredOtf::radial_product(double r) const {
  const Freq<double> f{r, 0.0};
  double product = aperture_radial(r) * options_.split.factor(r);
  for (const Entry<double>* entry : radial_) product *= entry->component.otf(f, system_.context()).re;
  if (chromatic_radial_.empty()) return product;
  if (!radial_mean_) return product * chromatic_product(f).re;
  double mean = 0.0;
  radial_mean_->at(r, {&mean, 1});
  return product * mean;
}

double FactoredOtf::aperture_mtf(Axis axis, double f) const {
  if (aperture_.kind != SceneAperture::Kind::box && aperture_.kind != SceneAperture::Kind::gaussian) return 1.0;
  const Frame<double>& frame = system_.frame;
  const double size_mm = 1e-3 * (axis == Axis::x ? aperture_.size.x_um(frame) : aperture_.size.y_um(frame));
  return aperture_.kind == SceneAperture::Kind::box ? sinc(size_mm * f).value : gaussian(size_mm * f).value;
}

double FactoredOtf::aperture_mtf(double r) const {
  if (aperture_.kind != SceneAperture::Kind::curve) return 1.0;
  const std::string_view unit = aperture_.curve->unit->name;
  const double f = unit == "cy/mrad" ? system_.frame.cy_per_mrad(r)
                   : unit == "cy/px" ? system_.frame.cy_per_px(r, Axis::x)
                                     : r;
  return evaluate(*aperture_.curve, f).value;
}

double FactoredOtf::aperture_factor(Axis axis, double f) const {
  return limited_inverse(aperture_mtf(axis, f), std::sqrt(aperture_.gain_limit)) *
         options_.taper.factor(axis == Axis::x ? 0 : 1, f);
}

double FactoredOtf::aperture_radial(double r) const { return limited_inverse(aperture_mtf(r), aperture_.gain_limit); }

double FactoredOtf::table_error() const {
  double sum = table_ ? table_->error() : 0.0;
  for (const Line& line : lines_) sum += line.table.line_error();
  for (const Slow& slow : polar_) sum += slow.table->error();
  return sum * gain();
}

double FactoredOtf::error() const {
  double dropped = 0.0;
  for (const Dropped& component : dropped_) dropped += component.bound;
  return table_error() + quadrature_error() + dropped * gain();
}

Complex<double> FactoredOtf::at(const Freq<double>& f) const {
  const double correction = aperture_factor(Axis::x, f.x) * aperture_factor(Axis::y, f.y) *
                            aperture_radial(std::hypot(f.x, f.y)) * options_.split.factor(std::hypot(f.x, f.y));
  Complex<double> h{correction, 0.0};
  for (const Stage stage : stages_) {
    std::vector<Entry<double>> list = system_.list(stage);
    for (std::size_t i = list.size(); i-- > 0;)
      if (is_given(stage, i)) list.erase(list.begin() + static_cast<std::ptrdiff_t>(i));
    h = h * system_.otf(std::span<const Entry<double>>(list), std::span(&f, 1)).front();
  }
  return options_.given ? h * options_.given->table->at(f) : h;
}

double FactoredOtf::axis_bound(Axis axis, double f_cy_mm) const {
  if (std::abs(f_cy_mm) >= cutoff_) return 0.0;
  const Freq<double> f = axis == Axis::x ? Freq<double>{f_cy_mm, 0.0} : Freq<double>{0.0, f_cy_mm};
  Complex<double> h{aperture_factor(axis, f_cy_mm), 0.0};
  for (const Entry<double>* entry : separable_) h = h * entry->component.otf(f, system_.context());
  const double radial = table_ ? table_->bound_from(std::abs(f_cy_mm))
                               : std::max(1.0, options_.split.factor(std::hypot(options_.fx_max, options_.fy_max)));
  return std::hypot(h.re, h.im) * radial * gain();
}

}  // namespace mtf
