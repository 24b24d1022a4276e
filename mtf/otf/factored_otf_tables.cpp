// SPDX-License-Identifier: Apache-2.0

// Tables of a sampler: factors along a direction, slow components over radius and direction, averages over the band.

#include <algorithm>
#include <cmath>
#include <memory>

#include "mtf/math/special.h"
#include "mtf/otf/factored_otf.h"
#include "mtf/parallel.h"

namespace mtf {
namespace {

constexpr int kMostWavelengths = 512;

// Radii at which a mean over the band is tested below those of even steps: `ratio` between neighbours, down to that
// share of the lesser of the two largest frequencies.
struct LowProbes {
  double ratio = 0.0, share = 0.0;
};
constexpr LowProbes kLowProbes{2.0, 0x1p-16}, kSlowLowProbes{4.0, 0x1p-12};

// The middles of `even` steps from 0 to `end`, and lower radii: an OTF may be narrow against `end`, which the axis with
// the smaller samples decides.
std::vector<double> probe_radii(double end, std::size_t even, const LowProbes& low, double lesser_nyquist_cy_mm) {
  std::vector<double> radii(even);
  for (std::size_t i = 0; i < even; ++i) radii[i] = end * (static_cast<double>(i) + 0.5) / static_cast<double>(even);
  const double least = std::max(low.share * lesser_nyquist_cy_mm, 0x1p-60 * end);
  for (double r = radii.front() / low.ratio; r > least; r /= low.ratio) radii.push_back(r);
  return radii;
}

Complex<float> narrow(const Complex<double>& h) { return {static_cast<float>(h.re), static_cast<float>(h.im)}; }

}  // namespace

void FactoredOtf::for_each(std::size_t count, const std::function<void(std::size_t)>& value) const {
  constexpr std::int64_t kAtOnce = 16;
  parallel_for_each(static_cast<std::int64_t>(count), kAtOnce, averaged_.empty() ? 1 : options_.threads,
                    [&](std::int64_t i) { value(static_cast<std::size_t>(i)); });
}

// Motion along one direction depends on f.u alone, an even function where it is real. A table that is too coarse for it
// leaves the component where it is.
void FactoredOtf::tabulate_lines(double target) {
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
void FactoredOtf::tabulate_slow(double target, const FactoredOtf* earlier) {
  // About how many values a table takes at least, and the most it may take: a rougher function gains nothing from one.
  constexpr std::int64_t kWorthIt = 4000, kMostEvaluations = 40000;
  if (!(options_.table_share > 0.0) || options_.samples < kWorthIt) return;
  const double end = std::hypot(options_.fx_max, options_.fy_max) * (1.0 + 1e-9);  // the corner itself lies within
  const auto add_kinks = [&](const Entry<double>* entry, const Context<double>& ctx, std::vector<double>& breaks) {
    for (const double r : entry->component.kinks_cy_mm(ctx)) breaks.push_back(std::min(r, end));
  };
  const auto keep = [&](const Entries& of, std::shared_ptr<const PolarTable> table) {
    polar_.push_back({of, std::move(table)});
    merged_.push_back(join_labels(of) + " -> one table over radius and direction");
  };
  const auto kept_before = [&](const Entries& of) {
    if (earlier == nullptr) return false;
    for (const Slow& slow : earlier->polar_)
      if (same_components(slow.of, of)) {
        keep(of, slow.table);
        return true;
      }
    return false;
  };
  const auto tabulate = [&](const Entries& of, const PolarTable::Function& h, const PolarTable::Rings& rings,
                            std::vector<double> breaks, std::int64_t most) {
    std::sort(breaks.begin(), breaks.end());
    auto table = std::make_shared<const PolarTable>(h, rings, std::move(breaks), target, most, options_.threads);
    if (table->error() > 20.0 * options_.table_share) return false;
    keep(of, std::move(table));
    return true;
  };
  const std::int64_t most = std::min(options_.samples, kMostEvaluations);
  const Context<double> ctx = system_.context();
  std::erase_if(general_, [&](const Entry<double>* entry) {
    if (!entry->component.is_slow()) return false;
    if (kept_before({entry})) return true;
    std::vector<double> breaks;
    add_kinks(entry, ctx, breaks);
    const PolarTable::Function h = [&](const Freq<double>& f) { return entry->component.otf(f, ctx); };
    return tabulate({entry}, h, reported(PolarTable::rings_of(h, options_.threads)), std::move(breaks), most);
  });
  if (chromatic_general_.empty()) return;
  if (kept_before(chromatic_general_)) return chromatic_general_.clear();
  std::vector<double> breaks;
  for (const Entry<double>* entry : chromatic_general_)
    for (const double wavelength : {system_.band->lo_um, system_.band->hi_um})
      add_kinks(entry, system_.context(wavelength), breaks);
  // Values at single wavelengths are shared by all frequencies, and the table of the band is smoother.
  constexpr std::int64_t kWavelengths = 16;
  const PolarTable::Function h = [this](const Freq<double>& f) { return chromatic_product(f); };
  const bool fixed = options_.wavelengths > 0;
  const PolarTable::Rings rings = fixed ? reported(PolarTable::rings_of(h, options_.threads)) : band_rings(end, target);
  if (tabulate(chromatic_general_, h, rings, std::move(breaks), fixed ? most : kWavelengths * most))
    chromatic_general_.clear();
}

PolarTable::Rings FactoredOtf::reported(PolarTable::Rings rings) const {
  return [this, rings = std::move(rings)](std::span<const double> r, std::size_t spokes,
                                          std::span<std::complex<double>> rows) {
    const std::int64_t values = rings(r, spokes, rows);
    if (options_.progress) options_.progress(values);
    return values;
  };
}

// The series around every ring at a few wavelengths, averaged over the band one by one. A pupil is among the slow
// components, so nothing is left beyond the last kink, its cutoff.
PolarTable::Rings FactoredOtf::band_rings(double end, double target) const {
  constexpr std::size_t kMostPanels = 64;
  const Band band = *system_.band;
  std::vector<double> breaks = chromatic_kinks();
  for (double& kink : breaks) kink /= band.hi_um;
  struct Kept {
    std::size_t spokes = 0;
    std::optional<BandMean> mean;
  };
  return [this, band, breaks, end, error = std::clamp(target / 64.0, 1e-9, 1e-7), kept = std::make_shared<Kept>()](
             std::span<const double> r, std::size_t spokes, std::span<std::complex<double>> rows) {
    const auto made = std::make_shared<std::int64_t>(0);
    const std::size_t orders = spokes / 2;
    if (kept->spokes != spokes) {
      const auto p = [this, made, spokes, orders](double wavelength_um, std::span<const double> t,
                                                  std::span<double> numbers) {
        const PolarTable::Function h = [&](const Freq<double>& f) { return product_at(f, wavelength_um); };
        std::vector<std::complex<double>> series(t.size() * orders);
        *made += reported(PolarTable::rings_of(h, options_.threads))(t, spokes, series);
        for (std::size_t i = 0; i < series.size(); ++i)
          numbers[2 * i] = series[i].real(), numbers[2 * i + 1] = series[i].imag();
      };
      kept->mean.emplace(p, 2 * orders, band, breaks, true, end,
                         BandMean::Options{.exact = 2 * orders, .error = error, .panels = kMostPanels});
      kept->spokes = spokes;
    }
    std::vector<double> numbers(2 * orders);
    for (std::size_t i = 0; i < r.size(); ++i) {
      kept->mean->at(r[i], numbers);
      for (std::size_t m = 0; m < orders; ++m) rows[i * orders + m] = {numbers[2 * m], numbers[2 * m + 1]};
    }
    return *made;
  };
}

// As those above, of slow components that depend on |f| alone.
void FactoredOtf::tabulate_band(double end) {
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
  constexpr std::size_t kProbes = 24;
  double worst = 0.0;
  for (const double r : probe_radii(end, kProbes, kSlowLowProbes, std::min(options_.fx_max, options_.fy_max))) {
    double mean = 0.0;
    radial_mean_->at(r, {&mean, 1});
    worst = std::max(worst, std::abs(mean - chromatic_product({r, 0.0}).re));
  }
  mean_error_ = 2.0 * worst;
}

Complex<double> FactoredOtf::product_at(const Freq<double>& f, double wavelength_um) const {
  const auto& list = chromatic_general_.empty() ? chromatic_radial_ : chromatic_general_;
  const Context<double> ctx = system_.context(wavelength_um);
  Complex<double> product{1.0, 0.0};
  for (const Entry<double>* entry : list) product = product * entry->component.otf(f, ctx);
  return product;
}

Complex<double> FactoredOtf::chromatic_product(const Freq<double>& f) const {
  WavelengthNodes own;
  const WavelengthNodes& nodes = wavelength_rule_.at(std::hypot(f.x, f.y), own);
  Complex<double> mean{};
  for (std::size_t w = 0; w < nodes.weight.size(); ++w)
    mean = mean + Complex<double>{nodes.weight[w], 0.0} * product_at(f, nodes.wavelength_um[w]);
  return mean;
}

std::vector<double> FactoredOtf::chromatic_kinks() const {
  const Context<double> middle = system_.context();
  std::vector<double> kinks;
  for (const auto* list : {&chromatic_radial_, &chromatic_general_})
    for (const Entry<double>* entry : *list)
      for (const double f : entry->component.kinks_cy_mm(middle)) kinks.push_back(f * middle.wavelength_um);
  std::sort(kinks.begin(), kinks.end());
  return kinks;
}

void FactoredOtf::choose_wavelengths(double end, double target) {
  // A radial product is the same in all directions; others are sampled in a few, less closely.
  const bool radial = chromatic_general_.empty(), fixed = options_.wavelengths > 0;
  const auto& list = radial ? chromatic_radial_ : chromatic_general_;
  const bool slow =
      std::any_of(list.begin(), list.end(), [](const Entry<double>* entry) { return entry->component.is_slow(); });
  const std::size_t directions = radial ? 1 : 4;
  const std::vector<double> radii =
      probe_radii(end, slow ? 8 : 128, slow ? kSlowLowProbes : kLowProbes, std::min(options_.fx_max, options_.fy_max));
  const std::vector<double> kinks = fixed ? std::vector<double>{} : chromatic_kinks();
  const auto averages = [&](int n) {
    wavelength_rule_ = BandRule(*system_.band, kinks, n);
    std::vector<Complex<double>> mean(radii.size() * directions);
    for_each(mean.size(), [&](std::size_t i) {
      const double r = radii[i / directions], a = 0.25 * static_cast<double>(i % directions);
      mean[i] = chromatic_product({r * cos_pi(a), r * sin_pi(a)});
    });
    return mean;
  };
  // A slow product takes the fewest wavelengths that suffice; for others the steps are wide.
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

FactoredOtf::Grid::Grid(const FactoredOtf& sampler, std::vector<double> fx, std::vector<double> fy)
    : sampler_(&sampler), fx_(std::move(fx)), fy_(std::move(fy)) {
  const Context<double> ctx = sampler.system_.context();
  const auto vector = [&](const std::vector<double>& f, Axis axis) {
    std::vector<Freq<double>> freq(f.size());
    std::vector<Complex<double>> h(f.size());
    for (std::size_t i = 0; i < f.size(); ++i) {
      freq[i] = axis == Axis::x ? Freq<double>{f[i], 0.0} : Freq<double>{0.0, f[i]};
      h[i] = {sampler.aperture_factor(axis, f[i]), 0.0};
    }
    for (const Entry<double>* entry : sampler.separable_) entry->component.multiply(freq, ctx, h);
    return h;
  };
  x_ = vector(fx_, Axis::x);
  y_ = vector(fy_, Axis::y);
  for (const Complex<double>& h : x_) narrow_x_.push_back(narrow(h));
  for (const Complex<double>& h : y_) narrow_y_.push_back(narrow(h));
  const double end = sampler.table_ ? sampler.table_->end() : 1.0;
  for (const double f : fx_) fx2_.push_back(static_cast<float>(f / end * (f / end)));
  for (const double f : fy_) fy2_.push_back(static_cast<float>(f / end * (f / end)));
  for (const FactoredOtf::Line& line : sampler.lines_) {
    const double x = line.direction.x / line.table.end(), y = line.direction.y / line.table.end();
    std::vector<float>& along_x = line_x_.emplace_back();
    std::vector<float>& along_y = line_y_.emplace_back();
    for (const double f : fx_) along_x.push_back(static_cast<float>(x * f));
    for (const double f : fy_) along_y.push_back(static_cast<float>(y * f));
  }
  for (const Entry<double>* entry : sampler.general_) rows_.push_back(entry->component.rows(fx_, ctx));
}

void FactoredOtf::Grid::multiply_radial(std::size_t j, std::span<float> value) const {
  if (sampler_->table_) sampler_->table_->multiply(std::span(fx2_).first(value.size()), fy2_[j], value);
}

void FactoredOtf::Grid::multiply_lines(std::size_t j, std::span<float> value, bool mirrored) const {
  for (std::size_t k = 0; k < line_x_.size(); ++k) {
    const float y = mirrored ? -line_y_[k][j] : line_y_[k][j];
    sampler_->lines_[k].table.multiply_line(std::span(line_x_[k]).first(value.size()), y, value);
  }
}

std::vector<Complex<double>> FactoredOtf::Grid::general_row(std::size_t j, std::size_t count, bool mirrored) const {
  const double fy = mirrored ? -fy_[j] : fy_[j];
  std::vector<Complex<double>> product(count, {1.0, 0.0});
  if (sampler_->radial_per_sample_)
    for (std::size_t i = 0; i < count; ++i) product[i].re = sampler_->radial_product(std::hypot(fx_[i], fy));
  for (const auto& multiply : rows_) multiply(fy, product);
  for (const Slow& slow : sampler_->polar_) slow.table->multiply(fx_, fy, product);
  if (sampler_->chromatic_general_.empty()) return product;
  for (std::size_t i = 0; i < count; ++i) product[i] = product[i] * sampler_->chromatic_product({fx_[i], fy});
  if (sampler_->options_.progress) sampler_->options_.progress(static_cast<std::int64_t>(count));
  return product;
}

void FactoredOtf::Grid::even_row(std::size_t j, std::span<float> value) const {
  const float y = narrow_y_[j].re;
  for (std::size_t i = 0; i < value.size(); ++i) value[i] = narrow_x_[i].re * y;
  multiply_radial(j, value);
}

void FactoredOtf::Grid::multiply_uneven(std::size_t j, std::span<float> value, bool mirrored) const {
  multiply_lines(j, value, mirrored);
  if (!sampler_->has_general()) return;
  const std::vector<Complex<double>> general = general_row(j, value.size(), mirrored);
  for (std::size_t i = 0; i < value.size(); ++i) value[i] *= static_cast<float>(general[i].re);
}

void FactoredOtf::Grid::real_row(std::size_t j, std::span<float> value, bool mirrored) const {
  even_row(j, value);
  multiply_uneven(j, value, mirrored);
}

void FactoredOtf::Grid::real_rows(std::size_t j, std::span<float> value, std::span<float> mirrored) const {
  even_row(j, value);
  std::copy(value.begin(), value.end(), mirrored.begin());
  multiply_uneven(j, value, false);
  multiply_uneven(j, mirrored, true);
}

void FactoredOtf::Grid::complex_row(std::size_t j, std::span<Complex<float>> value, bool mirrored) const {
  std::vector<float> tables(value.size(), 1.0F);
  multiply_radial(j, tables);
  multiply_lines(j, tables, mirrored);
  const Complex<float> y{narrow_y_[j].re, mirrored ? -narrow_y_[j].im : narrow_y_[j].im};
  for (std::size_t i = 0; i < value.size(); ++i) {
    const Complex<float> h = narrow_x_[i] * y;
    value[i] = {h.re * tables[i], h.im * tables[i]};
  }
  if (!sampler_->has_general()) return;
  const std::vector<Complex<double>> general = general_row(j, value.size(), mirrored);
  for (std::size_t i = 0; i < value.size(); ++i) value[i] = value[i] * narrow(general[i]);
}

void FactoredOtf::Grid::real_row(std::size_t j, std::span<double> value, bool mirrored) const {
  std::vector<Complex<double>> h(value.size());
  complex_row(j, std::span(h), mirrored);
  for (std::size_t i = 0; i < value.size(); ++i) value[i] = h[i].re;
}

void FactoredOtf::Grid::real_rows(std::size_t j, std::span<double> value, std::span<double> mirrored) const {
  real_row(j, value);
  real_row(j, mirrored, true);
}

void FactoredOtf::Grid::complex_row(std::size_t j, std::span<Complex<double>> value, bool mirrored) const {
  std::vector<float> tables(value.size(), 1.0F);
  multiply_radial(j, tables);
  multiply_lines(j, tables, mirrored);
  const std::vector<Complex<double>> general = general_row(j, value.size(), mirrored);
  const Complex<double> y{y_[j].re, mirrored ? -y_[j].im : y_[j].im};
  for (std::size_t i = 0; i < value.size(); ++i) {
    const Complex<double> h = x_[i] * y * general[i];
    value[i] = {h.re * tables[i], h.im * tables[i]};
  }
}

}  // namespace mtf
