// SPDX-License-Identifier: Apache-2.0
#include "mtf/field/field_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include "mtf/components/wavefront.h"
#include "mtf/error.h"
#include "mtf/math/special.h"
#include "mtf/words.h"

namespace mtf {
namespace {

constexpr std::int64_t kMostValues = 10000, kFewValues = 500;  // of an OTF that a table takes
constexpr int kMostBandNodes = 32;
constexpr double kMostInAll = 1.5e6;   // values of an OTF at one wavelength, for all places
constexpr double kQuick = 0.01;        // of the time of a slow component
constexpr double kSomePlaces = 300.0;  // 17 x 17 and some between
constexpr double kRadiusShare = 2.0;   // of the error of a table, for interpolation along a radius
constexpr double kKinkShare = 0.5;     // of the error that is enough: the tables of a radius with kinks
constexpr double kWorstSafety = 2.0;   // of errors of a sum of tables, which tell of all radii in their panel
constexpr double kLeastPanel = 0.01;   // of a radius
constexpr double kMostBytes = 2e9;     // of all tables
constexpr double kLeastPiece = 0.02;   // of the end of a table

double distance(const Complex<double>& a, const Complex<double>& b) { return std::hypot(a.re - b.re, a.im - b.im); }

}  // namespace

double lebesgue(std::size_t n) { return 1.0 + 2.0 / kPi * std::log(static_cast<double>(n)); }

/// The components that change, as they are at one place of the image.
class FieldTables::ComponentsAt {
 public:
  ComponentsAt(const System<double>& system, std::span<const std::size_t> changing, bool chromatic,
               const FieldPoint<double>& q)
      : here_(system.at(q)) {
    for (const std::size_t i : changing) entries_.push_back(here_.list(Stage::presample)[i]);
    if (chromatic) {
      const WavelengthNodes nodes = wavelength_nodes(*here_.band, here_.band_nodes);
      for (std::size_t i = 0; i < nodes.weight.size(); ++i)
        wavelengths_.emplace_back(nodes.weight[i], here_.context(nodes.wavelength_um[i]));
    }
  }

  Complex<double> otf(const Freq<double>& f) const {
    const auto product = [&](const Context<double>& ctx) {
      Complex<double> h{1.0, 0.0};
      for (const Entry<double>& entry : entries_) h = h * entry.component.otf(f, ctx);
      return h;
    };
    if (wavelengths_.empty()) return product(here_.context());
    Complex<double> mean{};
    for (const auto& [weight, ctx] : wavelengths_) mean = mean + Complex<double>{weight, 0.0} * product(ctx);
    return mean;
  }
  std::vector<double> kinks() const {
    std::vector<Context<double>> ends{here_.context()};
    if (here_.band) ends = {here_.context(here_.band->lo_um), here_.context(here_.band->hi_um)};
    std::vector<double> kinks;
    for (const Entry<double>& entry : entries_)
      for (const Context<double>& ctx : ends)
        for (const double r : entry.component.kinks_cy_mm(ctx)) kinks.push_back(r);
    return kinks;
  }
  double cutoff() const {
    // The shortest wavelength reaches farthest.
    const Context<double> shortest = here_.band ? here_.context(here_.band->lo_um) : here_.context();
    double cutoff = std::numeric_limits<double>::infinity();
    for (const Entry<double>& entry : entries_) cutoff = std::min(cutoff, entry.component.cutoff_cy_mm(shortest));
    return cutoff;
  }
  Parities parities() const {
    Parities product;
    for (const Entry<double>& entry : entries_) {
      const Traits traits = entry.component.traits(here_.context());
      product = product * Parities(traits.real, traits.even_x, traits.even_y);
    }
    return product;
  }
  bool is_radial() const {
    return std::ranges::all_of(
        entries_, [&](const Entry<double>& entry) { return entry.component.traits(here_.context()).radial; });
  }

 private:
  System<double> here_;
  std::vector<Entry<double>> entries_;
  std::vector<std::pair<double, Context<double>>> wavelengths_;  ///< weights and contexts of the band's average
};

FieldTables::FieldTables(const System<double>& system, std::span<const FieldPoint<double>> outline, double end_cy_mm,
                         const FieldModesOptions& options)
    : system_(system), options_(options) {
  const std::vector<Entry<double>>& list = system.list(Stage::presample);
  const Context<double> ctx = system.context();
  std::vector<bool> changes(list.size());
  for (const FieldNumber<double>& number : system.field.numbers) changes.at(number.entry) = true;
  for (const FieldAngle& angle : system.field.angles) changes.at(angle.entry) = true;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Traits traits = list[i].component.traits(ctx);
    changes[i] = changes[i] || traits.placed;
    chromatic_ = chromatic_ || (changes[i] && system.band && traits.chromatic);
    slow_ = slow_ || (changes[i] && list[i].component.is_slow());
  }
  for (std::size_t i = 0; i < list.size(); ++i)
    if (changes[i] || (chromatic_ && list[i].component.traits(ctx).chromatic)) factor_.entries.push_back(i);

  if (chromatic_) system_.band_nodes = 4;  // until they are chosen
  double cutoff = 0.0;
  for (const FieldPoint<double>& q : outline) {
    const ComponentsAt part(system_, factor_.entries, chromatic_, q);
    cutoff = std::max(cutoff, part.cutoff());
    factor_.all = factor_.all + part.parities();
    const std::vector<double> kinks = part.kinks();
    breaks_.insert(breaks_.end(), kinks.begin(), kinks.end());
  }
  factor_.cutoff_cy_mm = cutoff;
  end_ = std::min(end_cy_mm, cutoff);
  std::erase_if(breaks_, [&](double r) { return !(r < end_); });
  std::sort(breaks_.begin(), breaks_.end());
  // Kinks that move over the field lie close together: one of them, and the table says what that costs.
  std::vector<double> apart{end_};
  for (std::size_t i = breaks_.size(); i-- > 0;)
    if (apart.back() - breaks_[i] > kLeastPiece * end_) apart.push_back(breaks_[i]);
  breaks_.assign(apart.rbegin(), apart.rend());

  const auto radius = [](const FieldPoint<double>& q) { return std::hypot(q.x, q.y); };
  const FieldPoint<double> corner = *std::ranges::max_element(outline, {}, radius);
  choose_band_nodes(std::array{corner, outline[outline.size() / 5], FieldPoint<double>{}}, options.band_error);
  wavelengths_ = std::max(1, system_.band_nodes) * (slow_ ? 1.0 : kQuick);
  if (const double farthest = radius(corner); farthest > 0.0 && turns(farthest)) try_radius(farthest);
}

// Wavelengths for the product of the components that change: what the last doubling changed is the error.
void FieldTables::choose_band_nodes(std::span<const FieldPoint<double>> places, double target) {
  constexpr int kRadii = 8;
  if (!chromatic_) return;
  const auto values = [&](int nodes) {
    system_.band_nodes = nodes;
    std::vector<Complex<double>> h;
    for (const FieldPoint<double>& q : places) {
      const ComponentsAt here(system_, factor_.entries, chromatic_, q);
      for (int i = 0; i < kRadii; ++i)
        for (const double a : {0.1, 0.35, 0.6, 0.85}) {
          const double r = std::min(end_, here.cutoff()) * (i + 0.5) / kRadii;
          h.push_back(here.otf({r * cos_pi(a), r * sin_pi(a)}));
        }
    }
    return h;
  };
  int nodes = 4;
  std::vector<Complex<double>> coarse = values(nodes);
  while (nodes < kMostBandNodes) {
    nodes *= 2;
    const std::vector<Complex<double>> fine = values(nodes);
    band_error_ = 0.0;
    for (std::size_t i = 0; i < fine.size(); ++i) band_error_ = std::max(band_error_, distance(fine[i], coarse[i]));
    if (band_error_ <= target) break;
    coarse = fine;
  }
}

std::vector<Freq<double>> FieldTables::some_frequencies() const {
  std::vector<Freq<double>> f;
  for (int i = 0; i < 16; ++i) {
    const double r = end_ * (i + 0.5) / 16.0, a = 0.618 * i;
    f.push_back({r * cos_pi(a), r * sin_pi(a)});
  }
  return f;
}

// Whether the OTF turns with the direction of the field point.
bool FieldTables::turns(double farthest) const {
  // Turned places may lie outside the positions of a table in x and y.
  const auto in_xy = [](const FieldNumber<double>& number) { return number.map && !number.map->radial; };
  if (std::ranges::any_of(system_.field.numbers, in_xy)) return false;
  for (const double r : {0.4 * farthest, farthest}) {
    const ComponentsAt on_x(system_, factor_.entries, chromatic_, {r, 0.0});
    for (const double angle : {0.3, 1.5707963267948966, 2.5, -2.0}) {
      const double c = std::cos(angle), s = std::sin(angle);
      const ComponentsAt turned(system_, factor_.entries, chromatic_, {r * c, r * s});
      for (const Freq<double>& f : some_frequencies())
        if (distance(on_x.otf(f), turned.otf({c * f.x - s * f.y, s * f.x + c * f.y})) > 0.1 * options_.table_error)
          return false;
    }
  }
  return true;
}

// The radii at which the shape of a pupil changes.
std::vector<double> FieldTables::kinks_of_radius(double farthest) const {
  constexpr int kSteps = 64;
  const auto shapes = [&](double r) {
    const System<double> here = system_.at({r, 0.0});
    std::vector<int> shape;
    for (const std::size_t i : factor_.entries)
      if (const auto* w = here.list(Stage::presample)[i].component.get_if<Wavefront<double>>())
        shape.push_back(w->rim().shape(obscuration_of(w->obscuration, here.context())));
    return shape;
  };
  std::vector<double> kinks;
  std::vector<int> before = shapes(0.0);
  for (int i = 1; i <= kSteps; ++i) {
    const double end = farthest * i / kSteps;
    std::vector<int> after = shapes(end);
    if (after == before) continue;
    double low = farthest * (i - 1) / kSteps, high = end;
    for (int halving = 0; halving < 48; ++halving) {
      const double middle = 0.5 * (low + high);
      (shapes(middle) == before ? low : high) = middle;
    }
    kinks.push_back(high);
    before = std::move(after);
  }
  return kinks;
}

// Tables along a radius, where few of them are enough.
void FieldTables::try_radius(double farthest) {
  double begin = 0.0;
  for (const double end : kinks_of_radius(farthest))
    if (end - begin > kLeastPanel * farthest && farthest - end > kLeastPanel * farthest)
      panels_.push_back({begin, end}), begin = end;
  panels_.push_back({begin, farthest});
  // Frequencies meet the edge of a cut pupil at radii of their own behind its kink, so that tables and polynomials
  // converge slowly; what they miss is said.
  const double target = is_parted() ? std::max(options_.table_error, kKinkShare * options_.enough / options_.worst_unit)
                                    : options_.table_error;
  std::vector<double> radii;  // of the tables
  double worst = 0.0;
  for (Panel& panel : panels_) worst = std::max(worst, fill(panel, radii, target));
  places_.clear();
  if (is_parted() || worst <= kRadiusShare * target) {
    for (const PolarTable& table : tables_)
      error_ = std::max(error_, is_parted() ? std::max(kWorstSafety * worst, table.error())
                                            : worst + lebesgue(panels_.front().points.x.size()) * table.error());
    return;
  }
  panels_.clear();
  tables_.clear();
  values_ = 0;
}

// Takes more points until interpolation between them keeps the target; returns what it misses.
double FieldTables::fill(Panel& panel, std::vector<double>& radii, double target) {
  constexpr std::array<std::size_t, 3> kPoints{5, 9, 17};  // every other of these is one of those before
  constexpr double kSame = 1e-12;
  double worst = 0.0;
  for (const std::size_t n : kPoints) {
    panel.points = Barycentric::with_ends(n);
    panel.tables.clear();
    for (const double t : panel.points.x) {
      const double r = panel.at(t);
      const auto known = std::ranges::find_if(radii, [r](double other) { return std::abs(r - other) < kSame; });
      panel.tables.push_back(static_cast<std::size_t>(known - radii.begin()));
      if (known != radii.end()) continue;
      tables_.push_back(table_of(ComponentsAt(system_, factor_.entries, chromatic_, {r, 0.0}), target));
      radii.push_back(r);
    }
    worst = 0.0;
    for (const double share : {0.03, 0.37, 0.71, 0.97}) {
      const FieldPoint<double> q{panel.at(2.0 * share - 1.0), 0.0};
      places_.clear();
      prepare(std::span(&q, 1));
      const ComponentsAt exact(system_, factor_.entries, chromatic_, q);
      const PolarTable table = at(0);
      for (const Freq<double>& f : some_frequencies()) worst = std::max(worst, distance(exact.otf(f), table.at(f)));
    }
    if (worst <= kRadiusShare * target) break;
  }
  return worst;
}

std::vector<double> FieldTables::kinks() const {
  std::vector<double> kinks;
  for (std::size_t i = 1; i < panels_.size(); ++i) kinks.push_back(panels_[i].begin);
  return kinks;
}

std::vector<FieldTables::Share> FieldTables::shares_at(double radius) const {
  const auto panel = std::find_if(panels_.begin(), panels_.end() - 1, [&](const Panel& p) { return radius < p.end; });
  const double t = 2.0 * (radius - panel->begin) / (panel->end - panel->begin) - 1.0;
  std::vector<double> weight(panel->tables.size());
  panel->points.weights_at(std::clamp(t, -1.0, 1.0), weight.data());
  std::vector<Share> shares;
  for (std::size_t i = 0; i < weight.size(); ++i) shares.push_back({panel->tables[i], weight[i]});
  return shares;
}

PolarTable FieldTables::table_of(const ComponentsAt& part, double target) {
  const PolarTable::Function h = [&part](const Freq<double>& f) { return part.otf(f); };
  const auto most = static_cast<std::int64_t>(kMostInAll / (wavelengths_ * kSomePlaces));
  PolarTable table(h, PolarTable::rings_of(h, options_.threads, part.is_radial()), breaks_, target,
                   std::clamp(most, kFewValues, kMostValues), options_.threads);
  values_ += table.evaluations();
  if (options_.progress) options_.progress(table.evaluations());
  return table;
}

bool FieldTables::is_dear(std::size_t places) const {
  if (!panels_.empty() || places_.empty()) return false;
  const double each = static_cast<double>(values_) / static_cast<double>(places_.size());
  return each * static_cast<double>(places) * wavelengths_ > kMostInAll;
}

void FieldTables::prepare(std::span<const FieldPoint<double>> places) {
  last_.clear();
  for (const FieldPoint<double>& q : places) {
    const auto known = std::find_if(places_.begin(), places_.end(),
                                    [&](const Place& place) { return place.q.x == q.x && place.q.y == q.y; });
    last_.push_back(static_cast<std::size_t>(known - places_.begin()));
    if (known != places_.end()) continue;
    if (!panels_.empty()) {
      places_.push_back({q, shares_at(std::hypot(q.x, q.y)), std::atan2(q.y, q.x)});
      continue;
    }
    tables_.push_back(table_of(ComponentsAt(system_, factor_.entries, chromatic_, q), options_.table_error));
    places_.push_back({q, {{tables_.size() - 1, 1.0}}, 0.0});
    error_ = std::max(error_, tables_.back().error());
    bytes_ += tables_.back().bytes();
    const double bytes = static_cast<double>(bytes_) / static_cast<double>(places_.size()) *
                         static_cast<double>(std::max(places_.size(), places.size()));
    if (bytes > kMostBytes)
      throw UsageError("the OTFs at " + std::to_string(std::max(places_.size(), places.size())) +
                       " places of the image would take " + significant(1e-9 * bytes, 3) + " GB, where " +
                       significant(1e-9 * kMostBytes, 3) +
                       " are allowed; give terms by which the cutoff of the optics changes less");
  }
}

// A table turned by an angle has its orders turned by their phases.
PolarTable FieldTables::combined(std::span<const std::size_t> places, std::span<const double> weight) const {
  std::vector<std::vector<std::complex<double>>> of_table(tables_.size());
  std::vector<const PolarTable*> tables;
  std::size_t most = 0;  // orders
  for (std::size_t i = 0; i < tables_.size(); ++i) {
    tables.push_back(&tables_[i]);
    most = std::max(most, tables_[i].orders());
    of_table[i].resize(tables_[i].orders());
  }
  for (std::size_t k = 0; k < weight.size(); ++k) {
    const Place& place = places_[places[k]];
    std::vector<std::complex<double>> turn;
    for (std::size_t m = 0; m < most; ++m)
      turn.push_back(weight[k] * std::polar(1.0, -static_cast<double>(m) * place.angle));
    for (const auto& [table, share] : place.shares) {
      std::vector<std::complex<double>>& sum = of_table[table];
      for (std::size_t m = 0; m < sum.size(); ++m) sum[m] += share * turn[m];
    }
  }
  return PolarTable::combination(tables, of_table);
}

PolarTable FieldTables::at(std::size_t place) const {
  const Place& here = places_[last_[place]];
  if (here.shares.size() == 1) return tables_[here.shares.front().table];
  constexpr std::array one{1.0};
  return combined(std::span(&last_[place], 1), one);
}

PolarTable FieldTables::sum(std::span<const double> weight) const { return combined(last_, weight); }

}  // namespace mtf
