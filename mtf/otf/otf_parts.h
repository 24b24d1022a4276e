// SPDX-License-Identifier: Apache-2.0
#pragma once

// The OTF of a system by its parts, at many frequencies at once. Chromatic components of the presample list are
// averaged over the band as a product, those of the optics also by themselves: at few wavelengths, the same for all
// frequencies, where these suffice, else for each frequency between the kinks that the pupil has there (split_mean.h).
// What is the same along x and y is worked out once for both, and what is 1 along an axis not at all. Buffers and the
// nodes of the band are kept from one system to the next.

#include <algorithm>
#include <map>
#include <type_traits>
#include <vector>

#include "mtf/components/field.h"
#include "mtf/otf/split_mean.h"

namespace mtf {

/// Products at the frequencies asked for.
template <class S>
struct Products {
  std::vector<Complex<S>> optics, detector, presample;  ///< presample: the product of its whole list
  std::vector<Complex<S>> readout, after_sampling;      ///< after_sampling: readout and postsample
};

/// f-number, obscuration and wavelength of a pupil component: its own, or those of the optics.
template <class S>
struct PupilNumbers {
  S f_number{}, obscuration{}, wavelength_um{};
};

template <class S>
PupilNumbers<S> pupil_numbers(const Component<S>& component, const Context<S>& ctx) {
  std::optional<S> f_number, obscuration, wavelength_um;
  for (const FieldRef<S>& field : component.fields()) {
    const auto* own = std::get_if<std::optional<S>*>(&field.value);
    if (own == nullptr || !(*own)->has_value()) continue;
    if (field.info->name == "f_number") f_number = **own;
    if (field.info->name == "obscuration") obscuration = **own;
    if (field.info->name == "wavelength") wavelength_um = **own;
  }
  return {f_number_of(f_number, ctx), obscuration_of(obscuration, ctx), wavelength_um.value_or(ctx.wavelength_um)};
}

/// True when the samples become a continuous image, so that the spectrum after sampling ends somewhere.
template <class S>
bool is_reconstructed(const System<S>& system) {
  const auto& list = system.list(Stage::postsample);
  return std::ranges::any_of(list, [](const Entry<S>& entry) { return entry.component.is_reconstruction(); });
}

template <class S>
class OtfParts {
 public:
  /// Keeps a reference to `system` until the next call; the system must not change before that.
  void set(const System<S>& system) {
    system_ = &system;
    middle_ = system.context();
    pupil_ = nullptr;
    kept_count_ = 0;
    chromatic_.clear();
    steady_.clear();
    after_.clear();
    for (const Entry<S>& entry : system.list(Stage::presample)) {
      const SensorPart part = entry.component.part();
      const Member member{&entry.component, entry.component.traits(middle_),
                          part == SensorPart::optics     ? &Products<S>::optics
                          : part == SensorPart::detector ? &Products<S>::detector
                                                         : &Products<S>::presample};
      (system.band && member.traits.chromatic ? chromatic_ : steady_).push_back(member);
      if (entry.component.is_pupil()) pupil_ = &entry.component;
    }
    for (const auto& [stage, product] :
         {std::pair{Stage::readout, &Products<S>::readout}, std::pair{Stage::postsample, &Products<S>::after_sampling}})
      for (const Entry<S>& entry : system.list(stage))
        after_.push_back({&entry.component, entry.component.traits(middle_), product});
    if (system.band && (system.band->lo_um != lo_um_ || system.band->hi_um != hi_um_ || system.band->rate != rate_)) {
      nodes_.clear();
      lo_um_ = system.band->lo_um, hi_um_ = system.band->hi_um, rate_ = system.band->rate;
      weights_.set(*system.band);
    }
    find_kinks();
  }

  const System<S>& system() const { return *system_; }
  const Component<S>* pupil() const { return pupil_; }
  bool chromatic() const { return !chromatic_.empty(); }
  /// True when a component after sampling acts along the axis; digital filters count.
  bool filters(Axis axis) const {
    return std::ranges::any_of(after_, [axis](const Member& m) { return !is_flat(m, axis); });
  }
  bool digital_filters(Axis axis) const {
    return std::ranges::any_of(
        after_, [axis](const Member& m) { return m.product == &Products<S>::after_sampling && !is_flat(m, axis); });
  }
  bool chromatic_optics() const {
    return std::ranges::any_of(chromatic_, [](const Member& m) { return m.is_optics(); });
  }
  bool radial_optics() const {
    const auto radial = [](const Member& m) { return !m.is_optics() || m.traits.radial; };
    return std::ranges::all_of(steady_, radial) && std::ranges::all_of(chromatic_, radial);
  }

  /// Where the presample OTF ends, at the shortest wavelength; infinite without a pupil.
  double cutoff_cy_mm() const {
    const Context<S> shortest = system_->band ? system_->context(S(system_->band->lo_um)) : middle_;
    double cutoff = kInfinity;
    for (const auto* members : {&steady_, &chromatic_})
      for (const Member& m : *members) cutoff = std::min(cutoff, m.component->cutoff_cy_mm(shortest));
    return cutoff;
  }

  /// Where the OTF has kinks, rising: a pupil has them where the edges of its circles touch; a band has weaker ones
  /// at the first and last of its wavelengths' kinks.
  std::vector<double> kinks_cy_mm() const {
    std::vector<double> kinks;
    for (const double touch : touch_) {
      if (pupil_chromatic_ && hi_um_ > 0.0) kinks.push_back(touch / hi_um_);
      kinks.push_back(touch / (pupil_chromatic_ ? lo_um_ : 1.0));
    }
    std::ranges::sort(kinks);
    return kinks;
  }
  /// The frequencies where few wavelengths err most: those with kinks at wavelengths amid the band.
  std::vector<double> worst_cy_mm() {
    std::vector<double> worst;
    if (!pupil_chromatic_) return worst;
    constexpr int kAmid = 3;
    for (const double wavelength_um : band_nodes(kAmid).wavelength_um)
      for (const double touch : touch_) worst.push_back(touch / wavelength_um);
    return worst;
  }

  /// The optics at one wavelength, which have a pupil.
  struct OpticsAt {
    Context<S> context;  ///< of chromatic components
    double cutoff_cy_mm = 0.0;
    std::vector<double> kinks_cy_mm{};
    S ideal_area{};  ///< of the OTF of the pupil without aberration: pi (1 - e^2) / (lambda N)^2 / 4, (cy/mm)^2
  };
  /// `wavelength_um` says nothing where none of the optics is chromatic.
  OpticsAt optics_at(double wavelength_um) const {
    OpticsAt at{chromatic() ? system_->context(S(wavelength_um)) : middle_};
    at.cutoff_cy_mm = kInfinity;
    each_of_optics(at.context, [&](const Component<S>& component, const Context<S>& context) {
      at.cutoff_cy_mm = std::min(at.cutoff_cy_mm, component.cutoff_cy_mm(context));
    });
    const Context<S>& own = pupil_chromatic_ ? at.context : middle_;
    at.kinks_cy_mm = pupil_->kinks_cy_mm(own);
    const PupilNumbers<S> p = pupil_numbers(*pupil_, own);
    const S cutoff = S(1e3) / (p.wavelength_um * p.f_number);
    at.ideal_area = S(0.25 * kPi) * (S(1) - p.obscuration * p.obscuration) * cutoff * cutoff;
    return at;
  }
  /// The optics at that wavelength, in any direction.
  void optics(const OpticsAt& at, std::span<const Freq<S>> f, std::vector<Complex<S>>& product) const {
    product.assign(f.size(), one());
    each_of_optics(at.context, [&](const Component<S>& component, const Context<S>& context) {
      component.multiply(f, context, product);
    });
  }
  /// The Gauss rule of n wavelengths for what is smooth over the band.
  const WavelengthNodes& band_nodes(int n) {
    auto& nodes = nodes_[n];
    if (nodes.weight.empty()) nodes = wavelength_nodes(*system_->band, n);
    return nodes;
  }

  /// The largest number of wavelengths at a frequency.
  int wavelengths() const { return most_wavelengths_; }
  /// Takes the Gauss rule of n wavelengths for every frequency; `error`: what is known of its error.
  void use_wavelengths(int n, double error) {
    wavelengths_ = most_wavelengths_ = n;
    band_error_ = error;
  }
  /// Takes as many wavelengths as each frequency needs for that tolerance.
  void use_tolerance(double tolerance) {
    wavelengths_ = most_wavelengths_ = 0;
    split_tolerance_ = tolerance;
    band_error_ = 0.0;
  }
  /// The estimated error of the means over the band since then.
  double band_error() const { return band_error_; }

  /// All products along an axis.
  void along(Axis axis, std::span<const S> f_cy_mm, Products<S>& products) {
    const Kept& kept = keep(f_cy_mm);
    products = kept.products;
    const std::span<const Freq<S>> f = places(axis, f_cy_mm);
    const auto own = [&](const Member& m) { return !same_along_both(m) && !is_flat(m, axis); };
    multiply(steady_, f, products, own);
    multiply(after_, f, products, own);
    times(products.presample, products.detector);
    times(products.presample, products.optics);
    times(products.after_sampling, products.readout);
    if (chromatic_.empty()) return;
    if (!all_same_along_both(chromatic_)) average(f, own_means_);
    const BandMeans& means = all_same_along_both(chromatic_) ? kept.means : own_means_;
    times(products.optics, means.optics);
    times(products.presample, means.presample);
  }

  /// Readout and postsample along an axis.
  void after(Axis axis, std::span<const S> f_cy_mm, std::vector<Complex<S>>& product) {
    const std::span<const Freq<S>> f = places(axis, f_cy_mm);
    product.assign(f.size(), one());
    for (const Member& m : after_)
      if (!is_flat(m, axis)) m.component->multiply(f, middle_, product);
  }

 private:
  struct Member {
    const Component<S>* component;
    Traits traits;
    std::vector<Complex<S>> Products<S>::*product;  ///< the member that holds it
    bool is_optics() const { return product == &Products<S>::optics; }
  };
  /// The product of the chromatic components, averaged over the band.
  struct BandMeans {
    std::vector<Complex<S>> optics, presample;
  };
  /// The factors that do not depend on the axis, at frequencies that were asked for.
  struct Kept {
    std::vector<S> f_cy_mm;
    int wavelengths = 0;
    double tolerance = 0.0;
    Products<S> products;  ///< each holds the product of its own components alone
    BandMeans means;
  };

  // Axes with the same values may differ in derivatives: only numbers are shared or left out.
  static constexpr bool kValuesAlone = std::is_floating_point_v<S>;
  static bool same_along_both(const Member& m) { return kValuesAlone && (m.traits.radial || m.traits.square); }
  static bool all_same_along_both(const std::vector<Member>& members) {
    return std::ranges::all_of(members, same_along_both);
  }
  static bool is_flat(const Member& m, Axis axis) {
    return kValuesAlone && (axis == Axis::x ? m.traits.flat_x : m.traits.flat_y);
  }

  template <class Visit>
  void each_of_optics(const Context<S>& chromatic, Visit visit) const {
    for (const Member& m : steady_)
      if (m.is_optics()) visit(*m.component, middle_);
    for (const Member& m : chromatic_)
      if (m.is_optics()) visit(*m.component, chromatic);
  }

  static Complex<S> one() { return {S(1), S(0)}; }
  static void start(Products<S>& products, std::size_t count) {
    for (auto* product :
         {&products.optics, &products.detector, &products.presample, &products.readout, &products.after_sampling})
      product->assign(count, one());
  }
  static void times(std::vector<Complex<S>>& a, const std::vector<Complex<S>>& b) {
    for (std::size_t i = 0; i < a.size(); ++i) a[i] = a[i] * b[i];
  }
  template <class Wanted>
  void multiply(const std::vector<Member>& members, std::span<const Freq<S>> f, Products<S>& products,
                Wanted wanted) const {
    for (const Member& m : members)
      if (std::invoke(wanted, m)) m.component->multiply(f, middle_, products.*m.product);
  }
  std::span<const Freq<S>> places(Axis axis, std::span<const S> f_cy_mm) {
    places_.clear();
    for (const S& f : f_cy_mm) places_.push_back(axis == Axis::x ? Freq<S>{f, S(0)} : Freq<S>{S(0), f});
    return places_;
  }

  const Kept& keep(std::span<const S> f_cy_mm) {
    if (kValuesAlone)
      for (std::size_t i = 0; i < kept_count_; ++i)
        if (const Kept& kept = kept_[i];
            kept.wavelengths == wavelengths_ && kept.tolerance == split_tolerance_ &&
            std::equal(f_cy_mm.begin(), f_cy_mm.end(), kept.f_cy_mm.begin(), kept.f_cy_mm.end()))
          return kept;
    if (!kValuesAlone) kept_count_ = 0;
    if (kept_count_ == kept_.size()) kept_.emplace_back();
    Kept& kept = kept_[kept_count_++];
    kept.f_cy_mm.assign(f_cy_mm.begin(), f_cy_mm.end());
    kept.wavelengths = wavelengths_;
    kept.tolerance = split_tolerance_;
    const std::span<const Freq<S>> f = places(Axis::x, f_cy_mm);
    start(kept.products, f.size());
    multiply(steady_, f, kept.products, same_along_both);
    multiply(after_, f, kept.products, same_along_both);
    if (!chromatic_.empty() && all_same_along_both(chromatic_)) average(f, kept.means);
    return kept;
  }

  void find_kinks() {
    touch_.clear();
    pupil_chromatic_ =
        pupil_ != nullptr && std::ranges::any_of(chromatic_, [this](const Member& m) { return m.component == pupil_; });
    if (pupil_ == nullptr) return;
    const Context<S> ctx = pupil_chromatic_ ? system_->context(S(lo_um_)) : middle_;
    for (const double f : pupil_->kinks_cy_mm(ctx)) touch_.push_back(f * (pupil_chromatic_ ? lo_um_ : 1.0));
  }

  void average(std::span<const Freq<S>> f, BandMeans& means) {
    const bool beyond = !std::ranges::all_of(chromatic_, [](const Member& m) { return m.is_optics(); });
    means.optics.assign(f.size(), Complex<S>{S(0), S(0)});
    means.presample = means.optics;
    if (wavelengths_ == 0) return split_average(f, means, beyond);
    const WavelengthNodes& nodes = band_nodes(wavelengths_);
    for (std::size_t w = 0; w < nodes.weight.size(); ++w) {
      const Context<S> ctx = system_->context(S(nodes.wavelength_um[w]));
      node_.assign(f.size(), Complex<S>{S(nodes.weight[w]), S(0)});
      for (const Member& m : chromatic_)
        if (m.is_optics()) m.component->multiply(f, ctx, node_);
      for (std::size_t i = 0; i < f.size(); ++i) means.optics[i] = means.optics[i] + node_[i];
      if (!beyond) continue;
      for (const Member& m : chromatic_)
        if (!m.is_optics()) m.component->multiply(f, ctx, node_);
      for (std::size_t i = 0; i < f.size(); ++i) means.presample[i] = means.presample[i] + node_[i];
    }
    if (!beyond) means.presample = means.optics;
  }

  void split_average(std::span<const Freq<S>> f, BandMeans& means, bool beyond) {
    std::vector<double> kinks_um;
    for (std::size_t i = 0; i < f.size(); ++i) {
      const double radius_cy_mm = std::hypot(value_of(f[i].x), value_of(f[i].y));
      kinks_um.clear();
      double end_um = kInfinity;
      if (pupil_chromatic_ && radius_cy_mm > 0.0) {
        for (const double touch : touch_) kinks_um.push_back(touch / radius_cy_mm);
        if (!touch_.empty()) end_um = kinks_um.back();
      }
      const auto at = [&](double wavelength_um) {
        const Context<S> ctx = system_->context(S(wavelength_um));
        std::array<Complex<S>, 2> value{one(), one()};
        for (const Member& m : chromatic_)
          if (m.is_optics()) m.component->multiply({&f[i], 1}, ctx, {&value[0], 1});
        value[1] = value[0];
        if (!beyond) return value;
        for (const Member& m : chromatic_)
          if (!m.is_optics()) m.component->multiply({&f[i], 1}, ctx, {&value[1], 1});
        return value;
      };
      const SplitMean<S, 2> mean = split_mean<S, 2>(weights_, kinks_um, end_um, split_tolerance_, at);
      means.optics[i] = mean.value[0];
      means.presample[i] = mean.value[1];
      band_error_ = std::max(band_error_, mean.error);
      most_wavelengths_ = std::max(most_wavelengths_, mean.wavelengths);
    }
  }

  const System<S>* system_ = nullptr;
  Context<S> middle_;
  const Component<S>* pupil_ = nullptr;
  std::vector<Member> steady_, chromatic_, after_;  ///< after_: readout, then postsample
  std::vector<Kept> kept_;                          ///< the first kept_count_ belong to this system
  std::size_t kept_count_ = 0;
  double lo_um_ = 0.0, hi_um_ = 0.0;
  std::shared_ptr<const ElectronRate> rate_;
  std::map<int, WavelengthNodes> nodes_;
  mutable BandWeights weights_;
  std::vector<double> touch_;     ///< frequencies where edges of the pupil touch, the cutoff last; x um in a band
  bool pupil_chromatic_ = false;  ///< true: touch_ changes with the wavelength
  int wavelengths_ = 4, most_wavelengths_ = 4;  ///< 0: split
  double split_tolerance_ = 1e-6, band_error_ = 0.0;
  std::vector<Freq<S>> places_;
  BandMeans own_means_;
  std::vector<Complex<S>> node_;
};

}  // namespace mtf
