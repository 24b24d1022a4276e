// SPDX-License-Identifier: Apache-2.0
#pragma once

// Shared by plan.cpp (compiling), plan_run.cpp (running) and plan_explain.cpp (reporting); not installed as interface.

#include "mtf/engines/engine.h"
#include "mtf/plan.h"

namespace mtf {

struct Plan::Impl {
  System<double> system;
  std::vector<Stage> stages;
  PlanOptions options;
  PlanReport report;
  double dc = 1.0;
  std::shared_ptr<const Engine> engine;  ///< null for the identity
};

}  // namespace mtf
