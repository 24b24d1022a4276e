// SPDX-License-Identifier: Apache-2.0

// Plans of an OTF that changes over the image: one OTF where that is enough, else the mean OTF and modes of the image
// (mtf/field/field_modes.h) or of its tiles (field_tiles.h), whichever is quicker.

#include <algorithm>
#include <array>
#include <limits>

#include "mtf/engines/kept_plane.h"
#include "mtf/error.h"
#include "mtf/plan/plan_impl.h"
#include "mtf/words.h"

namespace mtf {
namespace {

// Of the cost of a run of the mean: one mode more, and its weights for a pixel and term.
constexpr double kModeAgain = 0.6, kModeWeightMs = 1.5e-7;
constexpr std::size_t kModesForTiles = 12;  // with fewer the whole image is as quick

}  // namespace

Plan compile_over_field(const System<double>& given, const SampleGrid& in, const SampleGrid& out,
                        const PlanOptions& options) {
  constexpr std::array stages{Stage::presample};
  const System<double> system = with_field_radius(given, out);
  const double tolerance = options.tolerance;
  const System<double> axis = system.at({});
  if (!(tolerance > 0.0 && tolerance < 1.0)) return compile_stages(axis, stages, in, out, options, {});  // refused
  if (options.method && !is_over_field(options.method) && family(name_of(*options.method)) != Family::fft)
    throw UsageError("method " + std::string(name_of(*options.method)) +
                     " takes one OTF for the whole image; here it changes over the field by " +
                     names_over_field(given) + ": leave --method out");
  require_spectrum_of(in, options);
  const Norms norms(in, out, options);
  const bool asked = options.method == Method::field_tiles;
  bool may_be_tiles = asked || (!options.method && std::min(out.width, out.height) >= 2 * FieldTiles::kLeastSide);
  const auto modes_of_image = [&] {
    return std::make_shared<const FieldModes>(
        system, in, out,
        FieldModesOptions{.aperture = options.aperture,
                          .table_error = std::clamp(0.1 * kTableShare * tolerance / norms.of_any(), 2e-9, 1e-6),
                          .band_error = kBandShare * tolerance / norms.of_any(),
                          .worst_unit = norms.of_any(),
                          .spectrum = options.spectrum.get(),
                          .spectrum_gain = norms.spectrum_gain,
                          .part_gain = options.border == Border::reflect ? 0.5 : 1.0,
                          .enough = kEnoughShare * tolerance,
                          .reach = may_be_tiles ? FieldTiles::kReach : 1.0,
                          .threads = options.threads,
                          .progress = options.progress});
  };
  std::shared_ptr<const FieldModes> field;
  try {
    field = modes_of_image();
  } catch (const UsageError&) {  // tables may be too large for tiles alone, which take more of the OTFs
    if (asked || !may_be_tiles) throw;
    may_be_tiles = false;
    field = modes_of_image();
  }
  FieldReport report{field->points(), 0, 0, field->error_of_axis()};
  std::vector<std::string> notes;
  if (system.frame.columns > out.width || system.frame.rows > out.height)
    notes.push_back("the scene covers " + size_text(out.width, out.height) + " pixels of the detector's " +
                    size_text(system.frame.columns, system.frame.rows) +
                    ", from its upper left corner: field points are those of the "
                    "whole detector");
  if (report.one_otf_error < tolerance && !is_over_field(options.method)) try {
      const Plan plan = compile_stages(axis, stages, in, out, options, {});
      if (plan.report().predicted.total() + report.one_otf_error <= tolerance) {
        auto impl = std::make_shared<Plan::Impl>(*plan.impl_);
        impl->system = given;
        impl->report.field = report;
        impl->report.notes.insert(impl->report.notes.end(), notes.begin(), notes.end());
        impl->report.predicted.modes = report.one_otf_error;
        Plan result;
        result.impl_ = std::move(impl);
        return result;
      }
    } catch (const UnreachableTolerance&) {  // said below
    }
  if (options.device.device)
    notes.push_back("the OTF changes over the field: its modes are the processor's work, not that of " +
                    options.device.device->info().name);
  PlanOptions own = on_processor(options);
  if (is_over_field(own.method)) own.method.reset();
  // What is added is rounded to the image each time, and so are its weights.
  const auto rounding = [&](std::size_t modes) {
    double error = 0.0;
    for (std::size_t k = 1; k <= modes; ++k)
      error += storage_error(options) + field->weight_rounding() * field->factor(k)->largest * norms.norm;
    return error;
  };
  const auto error_with = [&](std::size_t modes) { return field->error(modes) + rounding(modes); };
  while (report.modes <= field->count() && error_with(report.modes) > kModesShare * tolerance) ++report.modes;
  const bool follows = report.modes <= field->count();
  auto impl = std::make_shared<Plan::Impl>();
  impl->system = given;
  impl->stages.assign(stages.begin(), stages.end());
  impl->options = options;
  impl->options.progress = {};
  impl->field = field;
  const auto compile_mode = [&](std::size_t k, double share) {
    own.tolerance = share * tolerance;
    const Plan::Impl* earlier = k == 0 ? nullptr : impl->modes.back().impl_.get();  // with whose transforms it goes
    try {
      impl->modes.push_back(compile_stages(axis, stages, in, out, own,
                                           {.earlier = earlier, .mode = field->factor(k), .dc = k == 0 ? 1.0 : 0.0}));
    } catch (const UnreachableTolerance& e) {
      throw unreachable_tolerance(tolerance, std::min(1.0, e.reachable() / own.tolerance * tolerance), options.scene);
    }
  };
  compile_mode(0, kMeanShare);
  PlanReport total = impl->modes.front().report();
  const double mean_ms = impl->modes.front().impl_->cost_ms, count = static_cast<double>(report.modes);
  Candidate modes;
  modes.method = Method::field_modes;
  modes.detail = "the mean OTF and " + plural(static_cast<std::int64_t>(report.modes), "mode");
  modes.possible = follows;
  if (!follows) modes.reason = "does not keep the tolerance";
  modes.predicted.modes = field->error(std::min(report.modes, field->count()));
  modes.predicted.arithmetic = rounding(std::min(report.modes, field->count()));
  modes.cost_ms = mean_ms + count * (kModeAgain * mean_ms + kModeWeightMs * static_cast<double>(field->terms()) *
                                                                static_cast<double>(out.width * out.height));
  FieldTilesChoice choice;
  choice.candidate.method = Method::field_tiles;
  choice.candidate.reason = "planned for " + std::to_string(kModesForTiles) +
                            " modes and more of an image of several tiles, or where asked for by name";
  if (asked || (may_be_tiles && follows && report.modes >= kModesForTiles)) {
    const auto interpolate = [&](const SampleGrid& grid) {
      PlanOptions exact = on_processor(options);
      exact.method = Method::fft_float;
      exact.aperture = {};
      if (exact.scene) exact.scene->flat_rows = exact.scene->flat_columns = 0.0;
      System<double> nothing;
      nothing.frame = system.frame;
      return compile_stages(nothing, stages, in, grid, exact, {});
    };
    if (field->has_kinks())
      choice.candidate.reason = "the OTF has kinks over the field, where rims cut the pupil";
    else
      choice = choose_field_tiles({*field, axis, in, out, options, norms.norm, kModesShare * tolerance, interpolate});
    choice.candidate.cost_ms += mean_ms;
    choice.candidate.possible =
        choice.candidate.reason.empty() && choice.candidate.predicted.total() + total.predicted.total() <= tolerance;
    if (!choice.candidate.possible && choice.candidate.reason.empty())
      choice.candidate.reason = "does not keep the tolerance";
  }
  const bool quicker = choice.candidate.possible && choice.candidate.cost_ms < modes.cost_ms;
  Candidate* best = asked || quicker ? &choice.candidate : &modes;
  Candidate& other = best == &modes ? choice.candidate : modes;
  if (other.possible) other.reason = asked ? "another was asked for" : "takes longer";
  if (!best->possible) best = nullptr;
  if (best == nullptr && follows) throw UsageError("method field_tiles: " + choice.candidate.reason);
  if (best == nullptr) {
    // Modes of a tenth of the tolerance are left out on top of what the places miss.
    const double reachable = 1.01 * error_with(field->count()) / (kModesShare - kEnoughShare);
    const bool band = field->band_error() > 0.5 * error_with(field->count());
    throw UnreachableTolerance(
        "tolerance " + format_double(tolerance) + " cannot be kept: the OTF changes more sharply over " +
            (band ? std::string("the band than the wavelengths of its average can follow")
                  : "the field than OTFs at " + std::to_string(report.points) + " places can follow") +
            "; use " +
            (reachable < 1.0 ? significant(reachable, 3) + " or more"
             : band          ? "a narrower band"
                             : "weaker terms"),
        reachable < 1.0 ? reachable : std::numeric_limits<double>::infinity());
  }
  total.method = name_of(best->method);
  add(total.predicted, best->predicted);
  total.candidates.push_back(modes);
  total.candidates.push_back(choice.candidate);
  if (best->method == Method::field_tiles) {
    report.tiles = choice.tiles.size();
    report.modes = std::ranges::max_element(choice.tiles, {}, &TileModes::count)->count;
    require_memory(static_cast<double>(choice.candidate.bytes), out);
    impl->tiles = std::make_shared<const FieldTiles>(std::move(choice), options.border, options.threads);
    total.otf_bytes += impl->tiles->otf_bytes();
    total.run_bytes = std::max(total.run_bytes, impl->tiles->run_bytes());
  } else {
    double moduli = 0.0;  // of all modes but the mean: what each may err by is shared out by them
    for (std::size_t k = 1; k <= report.modes; ++k) moduli += field->factor(k)->largest;
    for (std::size_t k = 1; k <= report.modes; ++k) {
      compile_mode(k, (1.0 - kModesShare - kMeanShare) * field->factor(k)->largest / moduli);
      const PlanReport& mode = impl->modes.back().report();
      add(total.predicted, mode.predicted);
      total.otf_bytes += mode.otf_bytes;
      total.run_bytes = std::max(total.run_bytes, mode.run_bytes);
    }
  }
  total.tolerance = tolerance;
  total.field = report;
  total.notes.insert(total.notes.end(), notes.begin(), notes.end());
  impl->dc = impl->modes.front().dc();
  impl->report = std::move(total);
  Plan plan;
  plan.impl_ = std::move(impl);
  return plan;
}

// The mean first, then what each mode adds with its weights.
void Plan::run_modes(std::span<const ImageView<const float>> in, std::span<const ImageView<float>> out,
                     double border_value, int threads, std::span<KeptPlane> kept) const {
  std::vector<Image> copies;
  std::vector<ImageView<const float>> from;
  std::vector<KeptPlane> own(kept.empty() ? in.size() : 0);
  const std::span<KeptPlane> planes = kept.empty() ? std::span<KeptPlane>(own) : kept;
  for (std::size_t c = 0; c < in.size(); ++c)
    from.push_back(share_memory(in[c], out[c]) ? copies.emplace_back(copy_of(in[c])).view() : in[c]);
  const bool again = impl_->modes.size() > 1 || !kept.empty();
  impl_->modes.front().run_planes(from, out, border_value, threads, again ? planes : std::span<KeptPlane>());
  for (std::size_t k = 1; k < impl_->modes.size(); ++k)
    impl_->modes[k].run_planes(from, out, border_value, threads, planes,
                               [&](std::size_t c, std::int64_t y, std::int64_t x, std::span<const float> samples) {
                                 impl_->field->add(k, y, x, samples, out[c].row(y));
                               });
  if (!impl_->tiles) return;
  for (std::size_t c = 0; c < from.size(); ++c) impl_->tiles->add(from[c], out[c], border_value, threads);
}

}  // namespace mtf
