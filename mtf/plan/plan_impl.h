// SPDX-License-Identifier: Apache-2.0
#pragma once

// Shared by plan.cpp (compiling), plan_run.cpp (running) and plan_explain.cpp (reporting); not installed as interface.

#include "mtf/engines/engine.h"
#include "mtf/otf/factored_otf.h"
#include "mtf/plan/plan.h"

namespace mtf {

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
};

/// What compiling is besides its options: how it relates to a compilation before, and the part of the OTF that tiles
/// ask for.
struct Plan::Recompile {
  const Plan::Impl* earlier = nullptr;  ///< whose transforms are shared
  bool keep_family = false;             ///< only the family of methods of `earlier`
  bool tables = true;  ///< false: radial factors at every frequency, for tolerances that leave no room for a table
  ScaleSplit split = {};
};

}  // namespace mtf
