// SPDX-License-Identifier: Apache-2.0
#pragma once

// The OTF of a system by its parts, at many frequencies at once. Chromatic components of the presample list are
// averaged over the band as a product, those of the optics also by themselves. Buffers and the nodes of the band are
// kept from one system to the next.

#include <algorithm>
#include <map>
#include <vector>

#include "mtf/components/field.h"
#include "mtf/resolution.h"

namespace mtf {

/// Products at the frequencies asked for.
template <class S>
struct Products {
  std::vector<Complex<S>> optics, detector, presample;  ///< presample: everything in its list
  std::vector<Complex<S>> readout, after;               ///< after: readout and postsample
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

/// What follows sampling ends somewhere: a display, an eye, an interpolation. Digital filters are periodic.
template <class S>
bool ends_after_sampling(const System<S>& system) {
  constexpr std::array<std::string_view, 5> kinds{"interpolation", "sample_and_hold", "display_crt",
                                                  "display_flat_panel", "eye"};
  const auto& list = system.list(Stage::postsample);
  return std::any_of(list.begin(), list.end(), [&](const Entry<S>& entry) {
    return std::find(kinds.begin(), kinds.end(), entry.component.kind()) != kinds.end();
  });
}

template <class S>
class OtfParts {
 public:
  /// Looks at `system` until the next call; it stays as it is meanwhile.
  void set(const System<S>& system) {
    system_ = &system;
    middle_ = system.context();
    pupil_ = nullptr;
    chromatic_.clear();
    steady_.clear();
    after_.clear();
    for (const Entry<S>& entry : system.list(Stage::presample)) {
      const Traits traits = entry.component.traits(middle_);
      const Part part = part_of(entry.component.kind());
      (system.band && traits.chromatic ? chromatic_ : steady_).push_back({&entry.component, part, traits.radial});
      if (entry.component.is_pupil()) pupil_ = &entry.component;
    }
    readout_ = system.list(Stage::readout).size();
    for (const Stage stage : {Stage::readout, Stage::postsample})
      for (const Entry<S>& entry : system.list(stage)) after_.push_back({&entry.component, Part::other, false});
    if (system.band && (system.band->lo_um != lo_um_ || system.band->hi_um != hi_um_ || system.band->rate != rate_)) {
      nodes_.clear();
      lo_um_ = system.band->lo_um, hi_um_ = system.band->hi_um, rate_ = system.band->rate;
    }
  }

  const System<S>& system() const { return *system_; }
  const Component<S>* pupil() const { return pupil_; }
  bool chromatic() const { return !chromatic_.empty(); }
  /// Something follows sampling; digital filters among it.
  bool filters() const { return !after_.empty(); }
  bool digital_filters() const { return after_.size() > readout_; }
  bool radial_optics() const {
    const auto radial = [](const Member& m) { return m.part != Part::optics || m.radial; };
    return std::all_of(steady_.begin(), steady_.end(), radial) &&
           std::all_of(chromatic_.begin(), chromatic_.end(), radial);
  }

  /// Where the presample OTF ends, at the shortest wavelength; infinite without a pupil.
  double cutoff_cy_mm() const {
    const Context<S> shortest = system_->band ? system_->context(S(system_->band->lo_um)) : middle_;
    double cutoff = kInfinity;
    for (const auto* members : {&steady_, &chromatic_})
      for (const Member& m : *members) cutoff = std::min(cutoff, m.component->cutoff_cy_mm(shortest));
    return cutoff;
  }

  /// Kinks of a pupil at one wavelength: where the edges of its circles touch.
  std::vector<double> kinks_cy_mm() const {
    if (pupil_ == nullptr || chromatic()) return {};
    const double end = pupil_->cutoff_cy_mm(middle_), e = value_of(pupil_numbers(*pupil_, middle_).obscuration);
    if (!(e > 0.0) || !(end < kInfinity)) return {};
    return {0.5 * (1.0 - e) * end, e * end, 0.5 * (1.0 + e) * end};
  }

  /// Area of the unaberrated pupil's OTF, (cy/mm)^2: pi (1 - e^2) / (lambda N)^2 / 4, averaged over the band.
  S ideal_area() const {
    if (!chromatic()) return ideal_area(middle_);
    S mean{};
    const WavelengthNodes& nodes = band_nodes();
    for (std::size_t w = 0; w < nodes.weight.size(); ++w)
      mean += S(nodes.weight[w]) * ideal_area(system_->context(S(nodes.wavelength_um[w])));
    return mean;
  }

  int wavelengths() const { return wavelengths_; }
  void set_wavelengths(int n) { wavelengths_ = n; }

  void optics(std::span<const Freq<S>> f, std::vector<Complex<S>>& product) { presample(f, product, nullptr, nullptr); }

  void all(std::span<const Freq<S>> f, Products<S>& products) {
    presample(f, products.optics, &products.detector, &products.presample);
    after(f, products.after, &products.readout);
  }
  /// Readout and postsample; the former by itself where asked for and different.
  void after(std::span<const Freq<S>> f, std::vector<Complex<S>>& product, std::vector<Complex<S>>* readout = nullptr) {
    product.assign(f.size(), one());
    for (std::size_t i = 0; i < after_.size(); ++i) {
      if (readout != nullptr && i == readout_) *readout = product;
      after_[i].component->multiply(f, middle_, product);
    }
  }

 private:
  struct Member {
    const Component<S>* component;
    Part part;
    bool radial;
  };
  static Complex<S> one() { return {S(1), S(0)}; }

  S ideal_area(const Context<S>& ctx) const {
    const PupilNumbers<S> p = pupil_numbers(*pupil_, ctx);
    const S cutoff = S(1e3) / (p.wavelength_um * p.f_number);
    return S(0.25 * 3.14159265358979323846) * (S(1) - p.obscuration * p.obscuration) * cutoff * cutoff;
  }
  const WavelengthNodes& band_nodes() {
    auto& nodes = nodes_[wavelengths_];
    if (nodes.weight.empty()) nodes = wavelength_nodes(*system_->band, wavelengths_);
    return nodes;
  }
  const WavelengthNodes& band_nodes() const { return const_cast<OtfParts*>(this)->band_nodes(); }

  static void times(std::vector<Complex<S>>& a, const std::vector<Complex<S>>& b) {
    for (std::size_t i = 0; i < a.size(); ++i) a[i] = a[i] * b[i];
  }

  /// Without `whole` the optics alone.
  void presample(std::span<const Freq<S>> f, std::vector<Complex<S>>& optics, std::vector<Complex<S>>* detector,
                 std::vector<Complex<S>>* whole) {
    optics.assign(f.size(), one());
    if (whole != nullptr) detector->assign(f.size(), one()), whole->assign(f.size(), one());
    for (const Member& m : steady_)
      if (m.part == Part::optics)
        m.component->multiply(f, middle_, optics);
      else if (whole != nullptr)
        m.component->multiply(f, middle_, m.part == Part::detector ? *detector : *whole);
    if (whole != nullptr) times(*whole, *detector), times(*whole, optics);
    if (chromatic_.empty()) return;

    const WavelengthNodes& nodes = band_nodes();
    mean_optics_.assign(f.size(), Complex<S>{S(0), S(0)});
    mean_.assign(f.size(), Complex<S>{S(0), S(0)});
    const bool beyond =
        std::any_of(chromatic_.begin(), chromatic_.end(), [](const Member& m) { return m.part != Part::optics; });
    for (std::size_t w = 0; w < nodes.weight.size(); ++w) {
      const Context<S> ctx = system_->context(S(nodes.wavelength_um[w]));
      node_.assign(f.size(), Complex<S>{S(nodes.weight[w]), S(0)});
      for (const Member& m : chromatic_)
        if (m.part == Part::optics) m.component->multiply(f, ctx, node_);
      for (std::size_t i = 0; i < f.size(); ++i) mean_optics_[i] = mean_optics_[i] + node_[i];
      if (whole == nullptr || !beyond) continue;
      for (const Member& m : chromatic_)
        if (m.part != Part::optics) m.component->multiply(f, ctx, node_);
      for (std::size_t i = 0; i < f.size(); ++i) mean_[i] = mean_[i] + node_[i];
    }
    times(optics, mean_optics_);
    if (whole != nullptr) times(*whole, beyond ? mean_ : mean_optics_);
  }

  const System<S>* system_ = nullptr;
  Context<S> middle_;
  const Component<S>* pupil_ = nullptr;
  std::vector<Member> steady_, chromatic_, after_;  ///< after_: readout, then postsample
  std::size_t readout_ = 0;
  double lo_um_ = 0.0, hi_um_ = 0.0;
  std::shared_ptr<const ElectronRate> rate_;
  std::map<int, WavelengthNodes> nodes_;
  int wavelengths_ = 4;
  std::vector<Complex<S>> mean_, mean_optics_, node_;
};

}  // namespace mtf
