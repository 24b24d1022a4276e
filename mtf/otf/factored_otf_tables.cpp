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

}  // namespace

void FactoredOtf::for_each(std::size_t count, const std::function<void(std::size_t)>& value) const {
  constexpr std::int64_t kAtOnce = 16;
  parallel_for(static_cast<std::int64_t>(count), kAtOnce, averaged_.empty() ? 1 : options_.threads,
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t i = begin; i < end; ++i) value(static_cast<std::size_t>(i));
               });
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

}  // namespace mtf
