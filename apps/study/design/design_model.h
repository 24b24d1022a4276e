// SPDX-License-Identifier: Apache-2.0
#pragma once

// The model of a design for any scalar: values of the parameters in, metrics out. evaluator.cpp uses it with double,
// gradient.cpp with dual numbers (jets).

#include <algorithm>

#include "apps/study/design/design_light.h"
#include "apps/study/design/design_ranges.h"
#include "apps/study/design/evaluator.h"
#include "apps/study/design/variant_sensor.h"
#include "calib/fit/parameter_site.h"
#include "mtf/error.h"
#include "mtf/field/image_places.h"

namespace study {

/// The metrics of a study, and what has to be computed for them.
struct MetricPlan {
  std::vector<MetricChoice> choices;  ///< one for each of Study::metrics
  std::vector<std::size_t> at;        ///< index into needs.at, for mtf_at
  mtf::ResolutionNeeds needs;
  bool resolution = false, budget = false, spatial = false, giqe = false, bars = false, air = false, ttp = false;
  std::array<bool, kRangeTasks> range{};  ///< of range_tasks()
  std::vector<UnitScale> scale;
  std::vector<std::size_t> over_field;             ///< metrics that are wanted over the image: of choices, and
  std::shared_ptr<const MetricPlan> at_a_place{};  ///< what they alone need; null without any
};

MetricPlan plan_metrics(const Study& study, double tolerance);

template <class S>
class DesignModel {
 public:
  /// `place`: in the image; null for the optical axis. One for the axis holds one for each place where metrics want it.
  DesignModel(const Study& study, const MetricPlan& plan, const VariantSensor& variant, mtf::System<S> system,
              const mtf::ImagePlace* place = nullptr)
      : study_(&study),
        plan_(&plan),
        variant_(&variant),
        isoplanatic_(system.is_isoplanatic() && !(plan.budget && has_vignetting(variant))),
        system_(std::move(system)),
        meter_(plan.needs),
        range_meter_(curves_alone(std::is_same_v<S, double> ? kForDifferences : kForSlopes)) {
    if (place != nullptr) place_ = *place;
    if (!isoplanatic_ && plan.at_a_place) {
      const int along = mtf::image_places_along(system_, kMostAlong);
      follows_tables_ = mtf::follows_tables(system_, along);
      for (const mtf::ImagePlace& one : mtf::image_places(system_.frame.columns, system_.frame.rows, along))
        places_.push_back(std::make_unique<DesignModel>(study, *plan.at_a_place, variant, system_, &one));
    }
    for (const Parameter& parameter : study.parameters)
      sites_.push_back(calib::parameter_site(system_, parameter.path).numbers);
  }
  DesignModel(const DesignModel&) = delete;  // the sites are places in its own system
  DesignModel& operator=(const DesignModel&) = delete;

  /// Values of all parameters, in their units. A parameter of a table becomes an override.
  void set(std::span<const S> parameters) {
    overrides_.clear();
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const Parameter& parameter = study_->parameters[i];
      if (parameter.path.empty() || parameter.role == Parameter::Role::fixed) continue;
      for (S* number : sites_[i]) put(*number, parameters[i]);
      if (sites_[i].empty()) overrides_.push_back({parameter.path, parameters[i]});
    }
    for (const auto& place : places_) place->set(parameters);
  }
  /// The same as set(), also for parameters that vary as built.
  void set_fixed(std::size_t parameter, const S& value) {
    for (const auto& place : places_) place->set_fixed(parameter, value);
    for (S* number : sites_[parameter]) put(*number, value);
    if (!sites_[parameter].empty()) return;
    const std::string& path = study_->parameters[parameter].path;
    const auto found = std::ranges::find_if(overrides_, [&](const auto& o) { return o.path == path; });
    if (found != overrides_.end())
      found->value = value;
    else
      overrides_.push_back({path, value});
  }

  /// What of the light and its path the OTF depends on.
  void set_light(const DesignLight& light) {
    if (system_.band) system_.band->rate = light.rate;
    const auto scalar = [](const std::optional<double>& value) {
      return value ? std::optional<S>(*value) : std::nullopt;
    };
    system_.air = {scalar(light.air.path_length_m), scalar(light.air.scattering)};
    for (const auto& place : places_) place->set_light(light);
  }

  /// Of each metric that is wanted over the image, the place whose value was the worst in the last metrics().
  const std::vector<std::size_t>& worst_places() const { return worst_at_; }
  /// From now on a worst value is that of its place in `plain`, another scalar's model of the same design: the others
  /// are not looked at, unless a mean takes them all.
  template <class Plain>
  void follow(const DesignModel<Plain>& plain) {
    worst_at_ = plain.worst_places();
    follows_ = true;
  }

  /// With the numbers that are set, and with what changes over the image.
  const mtf::System<S>& system() const { return system_; }
  std::span<const radiometry::Override<S>> overrides() const { return overrides_; }

  /// Metrics in their units. `spectral`: of the overrides that are set. `roots`: of the ranges of this design with
  /// another light or another scalar; without them they are solved for.
  void metrics(const radiometry::SpectralNumbers<S>& spectral, const DesignLight& light, std::span<S> values,
               const RangeRoots* roots = nullptr) {
    if (!isoplanatic_)
      here_ = system_.at(place_ ? system_.field_point(place_->x_px, place_->y_px) : mtf::FieldPoint<S>{});
    design_.system = &here();
    design_.conditions = &study_->conditions;
    design_.range_m = target_range();
    if (variant_->loaded) design_.frame_time_s = radiometry::frame_time_s(here(), variant_->loaded->sensor.settings);
    if (plan_->resolution) design_.resolution = meter_.measure(here());
    design_.budget.reset();
    if (plan_->budget && variant_->loaded) design_.budget = budget(spectral);
    const bool saturated = design_.budget && design_.budget->saturation.saturated();
    if (plan_->giqe) design_.noise_gain = noise_gain();
    design_.observed = {};
    if (roots == nullptr) roots_ = {};
    refusal_.clear();
    caution_.clear();
    if (design_.budget && !saturated) {
      caution(words(design_.budget->saturation));
      caution(words(design_.budget->dither));
    }
    const auto moves_rim = [](const Parameter& p) {
      return p.path.find("vignetting_") != std::string::npos || p.path.find("obscuration") != std::string::npos;
    };
    if (!places_.empty() && has_vignetting(*variant_) &&
        variant_->loaded->sensor.settings.vignetting->of == radiometry::VignettingOf::wavefront &&
        std::ranges::any_of(study_->parameters, moves_rim))
      caution(
          "over the image, the light is that which the rims of the sensor file leave, whatever a design makes of them");
    if (design_.budget && plan_->spatial)
      refusal_ = radiometry::spatial_gap(variant_->loaded->sensor.settings, *design_.budget);
    const bool spatial = refusal_.empty();
    const auto taken =
        [this](auto model) {  // a model that refuses a design leaves the metrics of the others as they are
          try {
            model();
            return true;
          } catch (const mtf::UsageError& refused) {
            if (refusal_.empty()) refusal_ = refused.what();
            return false;
          }
        };
    if (plan_->bars && design_.budget && !saturated) taken([this] { observe_bars(design_); });
    if (light.course && spatial) taken([&] { find_ranges(light, roots); });
    if (light.course && design_.budget && !saturated)
      if (const auto held = target_saturation(*design_.budget, design_.budget->contrast_e); held.saturated())
        caution("the target of [conditions], at the scene and behind the sensor's own air, is " + words(held) +
                "; ranges take its contrast as if nothing held it");
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!taken([&] { values[i] = metric_value(plan_->choices[i], design_, plan_->at[i]); }))
        values[i] = detail::not_there<S>();
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!variant_->no_focus.empty() && is_at_a_range(*plan_->choices[i].row)) {
        values[i] = detail::not_there<S>();
        if (refusal_.empty()) refusal_ = variant_->no_focus;
      }
    const auto has_none = [](const S& value) { return std::isnan(mtf::value_of(value)); };
    if (saturated && std::any_of(values.begin(), values.end(), has_none)) refusal_ = words(design_.budget->saturation);
    if (plan_->resolution && design_.resolution.edge_lost && refusal_.empty())
      refusal_ =
          "the phase of the OTF moves edges, or draws them out, for more pixels than their figures (rer, fwhm, ...) "
          "follow, some hundred; or nothing ends it";
    if (plan_->resolution && design_.resolution.veiled && refusal_.empty())
      refusal_ =
          "no mtf50: next to f = 0 the MTF is below 1/2 already; what takes contrast from all frequencies (light "
          "scattered by aerosol, AC coupling) is no blur";
    take_over_field(spectral, light, values);
  }
  const RangeRoots& roots() const { return roots_; }
  /// What is resolved on the target at ranges within the reach of the air, by the design whose metrics() were made last
  /// with that light, ranges among them.
  std::vector<RangeSolver::Resolved> resolved(const DesignLight& light, bool by_bars,
                                              std::span<const double> range_m) requires std::is_same_v<S, double> {
    RangeModel<S> model = range_model(light);
    std::vector<RangeSolver::Resolved> found;
    for (const double range : range_m) found.push_back(solver_.resolved(model, by_bars, range));
    return found;
  }
  /// Why a metric of the last design has no number, "" where no model refused it.
  const std::string& refusal() const { return refusal_; }
  /// How far numbers of the last design are wrong: close to saturation, rounding without dither; "" without.
  const std::string& caution() const { return caution_; }
  /// What its ranges rest on: a range at Nyquist, a target that fills the field; "" without.
  std::string caution_of_ranges() const {
    std::string text;
    const auto add = [&](const char* what, bool RangeRoot::*flag) {
      std::string names;
      for (std::size_t i = 0; i < roots_.size(); ++i)
        if (roots_[i].*flag)
          names += (names.empty() ? what : ", ") + std::string(row_of(range_tasks(study_->conditions)[i].metric).name);
      text += (text.empty() || names.empty() ? "" : "; ") + names;
    };
    add("limited by the Nyquist frequency in ", &RangeRoot::at_nyquist);
    add("the target is wider than the field of view in ", &RangeRoot::fills_field);
    return text;
  }
  bool follows_tables() const { return follows_tables_; }
  double error() const {
    if (!follows_tables_) return 1.0;  // nothing is known
    double worst = plan_->resolution ? design_.resolution.error : 0.0;
    for (const RangeRoot& root : roots_) worst = std::max(worst, root.error);
    for (const auto& place : places_) worst = std::max(worst, place->error());
    return std::max(worst, image_error_);
  }

 private:
  /// As a pixel at its place sees it.
  const mtf::System<S>& here() const { return isoplanatic_ ? system_ : here_; }

  /// In place of the metrics that are wanted over the image: their mean, or the worst, of all places.
  void take_over_field(const radiometry::SpectralNumbers<S>& spectral, const DesignLight& light, std::span<S> values) {
    image_error_ = 0.0;
    if (places_.empty()) return;
    const std::vector<std::size_t>& wanted = plan_->over_field;
    const auto is_mean = [&](std::size_t k) { return plan_->choices[wanted[k]].over == Over::mean; };
    bool all = !follows_;
    for (std::size_t k = 0; k < wanted.size(); ++k) all = all || is_mean(k);
    if (!follows_) worst_at_.assign(wanted.size(), 0);
    std::vector<S> at_place(wanted.size()), mean(wanted.size()), every_other(wanted.size()), worst(wanted.size());
    std::vector<double> worst_of_those(wanted.size(), std::numeric_limits<double>::quiet_NaN());  // every other
    for (std::size_t p = 0; p < places_.size(); ++p) {
      if (!all && std::find(worst_at_.begin(), worst_at_.end(), p) == worst_at_.end()) continue;
      DesignModel& place = *places_[p];
      place.metrics(spectral, light, at_place);
      if (refusal_.empty()) refusal_ = place.refusal();
      for (std::size_t k = 0; k < wanted.size(); ++k) {
        const S& value = at_place[k];
        mean[k] += S(place.place_->weight) * value;
        every_other[k] += S(place.place_->every_other) * value;
        if (follows_) {
          if (worst_at_[k] == p) worst[k] = value;
          continue;
        }
        const bool less = plan_->choices[wanted[k]].row->less_is_better;
        const double now = mtf::value_of(value), before = mtf::value_of(worst[k]);
        const bool is_worse = less ? now > before : now < before;
        if (double& other = worst_of_those[k]; place.place_->every_other > 0.0)
          other = less ? std::fmax(other, now) : std::fmin(other, now);
        // Where a place has no value there is no worst of all.
        if (p > 0 && !std::isnan(now) && !is_worse) continue;
        worst[k] = value;
        worst_at_[k] = p;
      }
    }
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      values[wanted[k]] = is_mean(k) ? mean[k] : worst[k];
      const double value = mtf::value_of(mean[k]), miss = std::abs(value - mtf::value_of(every_other[k]));
      const double last = mtf::value_of(worst[k]), step = std::abs(last - worst_of_those[k]);
      if (is_mean(k) || !follows_) image_error_ = std::max(image_error_, miss / std::max(1.0, std::abs(value)));
      if (!is_mean(k) && !follows_) image_error_ = std::max(image_error_, step / std::max(1.0, std::abs(last)));
    }
  }

  void put(S& number, const S& value) {
    same_otf_ = same_otf_ && mtf::value_of(number) == mtf::value_of(value);
    number = value;
  }

  void caution(const std::string& said) {
    if (!said.empty()) caution_ += (caution_.empty() ? "" : "; ") + said;
  }

  /// To the target: that of [conditions], else of the sensor's air; NaN where neither says it.
  S target_range() const {
    if (study_->conditions.range_m) return S(*study_->conditions.range_m);
    if (!variant_->loaded) return detail::not_there<S>();
    const auto own = apps::stated_range_m(variant_->loaded->sensor.settings);
    if (!own) return detail::not_there<S>();
    return radiometry::Overrides<S>{std::span<const radiometry::Override<S>>(overrides_)}("atmosphere.range", *own);
  }

  RangeModel<S> range_model(const DesignLight& light) {
    const auto budget_of_light = [this](const radiometry::SpectralNumbers<double>& plain) {
      radiometry::SpectralNumbers<double> from = plain;
      radiometry::SpectralNumbers<S> to;
      const auto numbers = from.all();
      const auto scalars = to.all();
      for (std::size_t i = 0; i < scalars.size(); ++i) *scalars[i] = S(*numbers[i]);
      return budget(to);
    };
    return {isoplanatic_ ? system_ : here_,
            study_->conditions,
            design_.frame_time_s,
            *light.course,
            range_meter_,
            budget_of_light};
  }

  void find_ranges(const DesignLight& light, const RangeRoots* roots) {
    RangeModel<S> model = range_model(light);
    if constexpr (std::is_same_v<S, double>)
      if (roots == nullptr) {
        roots_ = solver_.solve(model, light.course, plan_->range, same_otf_, study_->tolerance);
        same_otf_ = true;
      }
    const std::array<RangeTask, kRangeTasks> tasks = range_tasks(study_->conditions);
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      if (!plan_->range[i]) continue;
      const RangeRoot& root = roots != nullptr ? (*roots)[i] : roots_[i];
      const bool moved = roots != nullptr && std::isfinite(root.found.range_m);
      design_.observed.range_m[i] = moved ? range_of(tasks[i], root, model) : S(root.found.range_m);
      if (refusal_.empty() && !root.refusal.empty())
        refusal_ = std::string(row_of(tasks[i].metric).name) + ": " + root.refusal;
    }
    if (plan_->ttp) design_.observed.ttp_cy_mrad = model.ttp_cy_mrad(model.at(0.0));
  }

  radiometry::Budget<S> budget(const radiometry::SpectralNumbers<S>& spectral) const {
    const radiometry::Sensor& sensor = variant_->loaded->sensor;
    return radiometry::sensor_budget(here(), sensor.settings, spectral, variant_->flicker_e,
                                     radiometry::Overrides<S>{std::span<const radiometry::Override<S>>(overrides_)},
                                     light_share(here(), sensor.settings, sensor.vignetting.get()));
  }

  /// Root of the mean of |OTF|^2 of the digital filters over the base band: the factor by which they raise white noise.
  S noise_gain() const {
    using std::sqrt;
    const auto& list = here().list(mtf::Stage::postsample);
    if (list.empty()) return S(1);
    const mtf::Context<S> context = here().context();
    const bool separable = std::all_of(list.begin(), list.end(),
                                       [&](const auto& entry) { return entry.component.traits(context).separable; });
    constexpr std::size_t kNodes = 12, kHalf = kNodes / 2;
    const mtf::GaussRule& rule = mtf::gauss_legendre(kNodes);
    const S nyquist_x = here().frame.nyquist_cy_mm(mtf::Axis::x), nyquist_y = here().frame.nyquist_cy_mm(mtf::Axis::y);
    // |OTF| is the same at f and -f: half of the nodes, with twice their weights.
    std::vector<mtf::Freq<S>> f;
    for (std::size_t i = 0; i < kHalf; ++i)
      if (separable) {
        f.push_back({S(rule.node[i]) * nyquist_x, S(0)});
        f.push_back({S(0), S(rule.node[i]) * nyquist_y});
      } else {
        for (const double y : rule.node) f.push_back({S(rule.node[i]) * nyquist_x, S(y) * nyquist_y});
      }
    const auto h = here().otf(std::span(list), f);
    const auto square = [&](std::size_t i) { return h[i].re * h[i].re + h[i].im * h[i].im; };
    S mean(0), mean_x(0), mean_y(0);
    for (std::size_t i = 0; i < kHalf; ++i)
      if (separable) {
        mean_x += S(rule.weight[i]) * square(2 * i);
        mean_y += S(rule.weight[i]) * square(2 * i + 1);
      } else {
        for (std::size_t j = 0; j < kNodes; ++j)
          mean += S(0.5 * rule.weight[i] * rule.weight[j]) * square(kNodes * i + j);
      }
    return sqrt(separable ? S(mean_x * mean_y) : mean);
  }

  /// Of the OTF at a root, by which ranges are differentiated: by jets, and by differences of the light.
  static constexpr double kForSlopes = 1e-6, kForDifferences = 1e-9;

  const Study* study_;
  const MetricPlan* plan_;
  const VariantSensor* variant_;
  bool isoplanatic_ = true;
  std::optional<mtf::ImagePlace> place_{};
  mtf::System<S> system_;
  mtf::System<S> here_{};  ///< of a system that changes over the image
  std::vector<std::unique_ptr<DesignModel>> places_{};
  std::vector<std::size_t> worst_at_{};
  bool follows_ = false;
  static constexpr int kMostAlong = 33;  ///< places of an axis: each has a model of its own
  bool follows_tables_ = true;           ///< the places are no farther apart than positions of tables
  double image_error_ = 0.0;             ///< of means and worsts over the image, as the metrics' errors are counted
  mtf::ResolutionMeter<S> meter_, range_meter_;
  std::vector<std::vector<S*>> sites_;
  std::vector<radiometry::Override<S>> overrides_;
  Design<S> design_;
  RangeSolver solver_{};
  RangeRoots roots_{};
  bool same_otf_ = false;  ///< as when the ranges were solved last
  std::string refusal_, caution_;
};

/// Derivatives of the metrics, objectives and constraints of a design by its axes, through the same code as their
/// values. `light`: of the design; null for one that cannot be (all derivatives are NaN). `parameters`: of the design,
/// in their units. The series of the OTF are taken to `tolerance`, whatever the study's. Numbers that enter only the
/// band integrals of radiance (is_spectral) are differentiated by differences of fourth order.
Gradient gradient_of(const Study& study, const VariantSensor& variant, const DesignLight* light,
                     std::span<const double> parameters, double tolerance = 1e-9);

}  // namespace study
