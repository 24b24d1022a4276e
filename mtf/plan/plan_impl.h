// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a plan holds, for the sources that compile and run it.

#include <cmath>
#include <functional>
#include <mutex>

#include "mtf/field/field_modes.h"
#include "mtf/plan/field_tiles.h"
#include "mtf/plan/plan_parts.h"

namespace mtf {

/// The plan of the processor in place of that of a device that has failed.
struct ProcessorPlan {
  std::mutex lock;
  std::optional<Plan> plan;
};

struct Plan::Impl {
  System<double> system;
  std::vector<Stage> stages;
  PlanOptions options;
  ScaleSplit split;
  PlanReport report;
  std::shared_ptr<const FactoredOtf> sampler;  ///< whose tables the plan of a changed system shares
  double dc = 1.0;
  double cost_ms = 0.0;                  ///< predicted, of the chosen candidate
  double family_choice_ms = 0.0;         ///< the same when all methods were last judged
  std::shared_ptr<const Engine> engine;  ///< null for the identity
  std::shared_ptr<ProcessorPlan> otherwise = std::make_shared<ProcessorPlan>();  ///< where the device fails
  std::shared_ptr<const FieldModes> field;  ///< of an OTF that changes over the image,
  std::vector<Plan> modes;                  ///< whose modes these filter, the mean first
  std::shared_ptr<const FieldTiles> tiles;  ///< what comes after the mean where that is all
  /// Of an OTF that changes from sample to sample: of each mode but the mean the weights of the samples, then the sum
  /// of weights of each pixel.
  std::shared_ptr<const std::vector<Image>> weights;
};

/// What compiling is besides its options: how it relates to a compilation before, and the part of the OTF that tiles
/// ask for.
struct Plan::Recompile {
  const Plan::Impl* earlier = nullptr;  ///< whose transforms are shared
  bool keep_family = false;             ///< only the family of methods of `earlier`
  bool tables = true;  ///< false: radial factors at every frequency, for tolerances that leave no room for a table
  ScaleSplit split = {};
  std::shared_ptr<const GivenFactor> mode = {};  ///< of an OTF that changes over the field
  double dc = 1.0;                               ///< of that factor
};

/// What an OTF error of 1 may become, as an rms error of the image relative to the scene's std.
struct Norms {
  Norms(const SampleGrid& in, const SampleGrid& out, const PlanOptions& options) {
    canvas = canvas_norm_of(options, in);
    // The error of the whole scene may concentrate in the part of it that the detector sees.
    norm = canvas * std::sqrt(std::max(1.0, in.area_um2() / out.area_um2()));
    alias = std::sqrt(samples_per_pixel(in, out));
    // A mirrored canvas is four images; an error that is not mirrored may concentrate in one of them.
    spectrum_gain = norm / canvas * (options.border == Border::reflect ? 2.0 : 1.0);
  }
  double canvas = 1.0, norm = 1.0;  ///< of the defined canvas; where all of it lies in the image
  double alias = 1.0;
  double spectrum_gain = 1.0;  ///< over the rms error of the scene's spectrum

  double of_any() const { return alias * norm; }
};

/// Whether planes overlap.
inline bool share_memory(ImageView<const float> a, ImageView<const float> b) {
  const std::less<const float*> before;
  return before(a.data, b.row(b.height)) && before(b.data, a.row(a.height));
}

/// Of the modes of an OTF that changes over the image, and of the device's plan in its place.
PlanOptions on_processor(PlanOptions options);

/// Throws UsageError where options.spectrum is of another scene.
void require_spectrum_of(const SampleGrid& in, const PlanOptions& options);

Plan compile_stages(const System<double>& system, std::span<const Stage> stages, const SampleGrid& in,
                    const SampleGrid& out, const PlanOptions& options, const Plan::Recompile& how);

// How the tolerance is shared out over a field: modes that are left out, the mean OTF, the others.
inline constexpr double kModesShare = 0.75, kMeanShare = 0.125;
inline constexpr double kEnoughShare = 0.1;  ///< for modes alone

inline bool is_over_field(const std::optional<Method>& method) {
  return method == Method::field_modes || method == Method::field_tiles;
}

/// Adds `factor` times the parts of b.
inline void add(PredictedError& a, const PredictedError& b, double factor = 1.0) {
  for (const auto part : {&PredictedError::dropped, &PredictedError::table, &PredictedError::band, &PredictedError::cut,
                          &PredictedError::wrap, &PredictedError::kernel, &PredictedError::modes, &PredictedError::flat,
                          &PredictedError::arithmetic})
    a.*part += factor * b.*part;
}

/// `system` is not isoplanatic; grids and system are valid.
Plan compile_over_field(const System<double>& system, const SampleGrid& in, const SampleGrid& out,
                        const PlanOptions& options);

/// The same of a system with entry_by_range() and options.range_m.
Plan compile_over_range(const System<double>& system, const SampleGrid& in, const SampleGrid& out,
                        const PlanOptions& options);

/// An OTF that each sample of a scene has its own of, along a line of one number: `line` changes over the field with x,
/// from where place = -1 to where it is 1; its optical axis is where the number has its mean.
struct SamplesOtf {
  System<double> line;
  std::vector<double> place{};  ///< of each sample
};
/// `mean`, in whose presample component `entry` a field goes from `first` to `last`.
System<double> along_line(System<double> mean, std::size_t entry, std::string_view field, double first, double last);

/// Each sample spreads by its own OTF, and each pixel is the mean with the weights that reach it:
/// out(x) = sum over u of h(x - u; place(u)) s(u) / sum over u of h(x - u; place(u)).
Plan compile_over_samples(const SamplesOtf& otf, const SampleGrid& in, const SampleGrid& out,
                          const PlanOptions& options);

}  // namespace mtf
