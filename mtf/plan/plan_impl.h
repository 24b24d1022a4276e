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

/// `system` is not isoplanatic; grids and system are valid.
Plan compile_over_field(const System<double>& system, const SampleGrid& in, const SampleGrid& out,
                        const PlanOptions& options);

}  // namespace mtf
