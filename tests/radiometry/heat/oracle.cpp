// SPDX-License-Identifier: Apache-2.0
#include "tests/radiometry/heat/oracle.h"

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_band.h>
#include <sunmatrix/sunmatrix_band.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>

#include "radiometry/light/constants.h"

namespace radiometry::heat::test {
namespace {

struct System {
  const Batch* batch;
  std::size_t facet;
  const Grid* grid;
  const Forcing* forcing;
  double begin_s = 0.0, end_s = 0.0;  ///< between two breaks
};

struct Side {
  double flow, slope;  ///< into the surface; its derivative
};

/// Evaporation as FAO-56 writes it: psychrometric constant 0.665e-3 P (eq. 8), the WMO's Magnus form for saturation.
Side evaporation(const SideForcing& from, double wet, double h, double air_pressure_pa, double t) {
  if (wet == 0.0) return {0.0, 0.0};
  const double celsius = t - 273.15, saturated = 611.2 * std::exp(17.62 * celsius / (243.12 + celsius));
  const double coefficient = wet * h / (1013.0 / (0.622 * 2.45e6) * air_pressure_pa);
  return {coefficient * (from.vapour_pa - saturated),
          -coefficient * saturated * 17.62 * 243.12 / std::pow(243.12 + celsius, 2)};
}

Side side(const SideForcing& from, double emissivity, const Convection& convection, double wet, double pressure_pa,
          double up, double t) {
  const NaturalConvection natural = natural_coefficient(convection, up);
  const double excess = t - from.air_k, sigma = kStefanBoltzmann_w_m2_k4;
  const double c = (excess > 0 ? natural.warm : natural.cold) * std::cbrt(std::abs(excess));
  const double h = forced_coefficient(convection, from.wind_m_s);
  const Side vapour = evaporation(from, wet, h, pressure_pa, t);
  return {from.absorbed_w_m2[0] - emissivity * sigma * std::pow(t, 4) - (h + c) * excess + vapour.flow,
          -4 * emissivity * sigma * std::pow(t, 3) - h - 4.0 / 3.0 * c + vapour.slope};
}

struct Ends {
  Side front, back;
  std::vector<double> source_w_m3;
};

Ends ends(const System& system, double time_s, const double* t) {
  double front[1] = {}, back[1] = {};
  const Construction& construction = system.batch->construction;
  const auto* sheet = std::get_if<Sheet>(&construction.inside);
  ForcingValues values{.front = {.absorbed_w_m2 = front}, .back = {}};
  if (sheet) values.back.absorbed_w_m2 = back;
  const bool at_end = time_s >= system.end_s;
  std::vector<double> source(construction.generates ? construction.layers.size() : 0);
  values.source_w_m3 = source;
  (*system.forcing)(
      {std::clamp(time_s, system.begin_s, system.end_s), at_end ? Instant::Limit::before : Instant::Limit::after},
      system.facet, values);
  const double up = system.batch->up.empty() ? 0.0 : system.batch->up[system.facet];
  const double last = t[system.grid->nodes() - 1], g = system.grid->inner_w_m2_k;
  const double pressure = construction.air_pressure_pa;
  Ends result{side(values.front, construction.emissivity, construction.convection, construction.wet_fraction, pressure,
                   up, t[0]),
              {},
              source};
  if (sheet)
    result.back = side(values.back, sheet->emissivity, sheet->convection, sheet->wet_fraction, pressure, -up, last);
  else if (std::holds_alternative<InnerFlux>(construction.inside))
    result.back = {values.inside, 0.0};
  else
    result.back = {g * (values.inside - last), -g};
  return result;
}

/// What layers generate in node i, by the depths that half cells reach to, not by the shares that the grid itself has.
double source_flow(const System& system, const std::vector<double>& source_w_m3, std::size_t i) {
  const Grid& grid = *system.grid;
  const std::vector<double>& depth = grid.depth_m;
  double whole = 0.0;
  for (const Layer& layer : system.batch->construction.layers) whole += layer.thickness_m;
  const bool fixed = std::holds_alternative<FixedTemperature>(system.batch->construction.inside);
  const double above = i > 0 ? 0.5 * (depth[i - 1] + depth[i]) : 0.0;
  const double below = i + 1 < grid.nodes()               ? 0.5 * (depth[i] + depth[i + 1])
                       : grid.inner_w_m2_k > 0.0 && fixed ? whole - 0.5 * (whole - depth[i])
                                                          : whole;
  double begin = 0.0, flow = 0.0;
  for (std::size_t k = 0; k < source_w_m3.size(); ++k) {
    const double end = begin + system.batch->construction.layers[k].thickness_m;
    flow += source_w_m3[k] * std::max(0.0, std::min(end, below) - std::max(begin, above));
    begin = end;
  }
  return flow;
}

int right_side(double time_s, N_Vector y, N_Vector ydot, void* user) {
  const System& system = *static_cast<const System*>(user);
  const Grid& grid = *system.grid;
  const double* t = N_VGetArrayPointer(y);
  double* rate = N_VGetArrayPointer(ydot);
  const std::size_t n = grid.nodes();
  const Ends at = ends(system, time_s, t);
  for (std::size_t i = 0; i < n; ++i) {
    double flow = 0.0;
    if (i > 0) flow += grid.conductance[i - 1] * (t[i - 1] - t[i]);
    if (i + 1 < n) flow += grid.conductance[i] * (t[i + 1] - t[i]);
    if (!at.source_w_m3.empty()) flow += source_flow(system, at.source_w_m3, i);
    if (i == 0) flow += at.front.flow;
    if (i + 1 == n) flow += at.back.flow;
    rate[i] = flow / grid.capacity[i];
  }
  return 0;
}

int jacobian(double time_s, N_Vector y, N_Vector, SUNMatrix matrix, void* user, N_Vector, N_Vector, N_Vector) {
  const System& system = *static_cast<const System*>(user);
  const Grid& grid = *system.grid;
  const Ends at = ends(system, time_s, N_VGetArrayPointer(y));
  const auto n = static_cast<sunindextype>(grid.nodes());
  for (sunindextype i = 0; i < n; ++i) {
    const auto row = static_cast<std::size_t>(i);
    const double outer = i > 0 ? grid.conductance[row - 1] : 0.0, inner = i + 1 < n ? grid.conductance[row] : 0.0;
    double own = -outer - inner;
    if (i == 0) own += at.front.slope;
    if (i + 1 == n) own += at.back.slope;
    SM_ELEMENT_B(matrix, i, i) = own / grid.capacity[row];
    if (i > 0) SM_ELEMENT_B(matrix, i, i - 1) = outer / grid.capacity[row];
    if (i + 1 < n) SM_ELEMENT_B(matrix, i, i + 1) = inner / grid.capacity[row];
  }
  return 0;
}

void check(int status, const char* what) {
  if (status < 0) throw std::runtime_error(std::string(what) + ": CVODE returned " + std::to_string(status));
}

struct FreeContext {
  void operator()(SUNContext c) const { SUNContext_Free(&c); }
};
struct FreeMemory {
  void operator()(void* m) const { CVodeFree(&m); }
};

}  // namespace

OracleRun oracle(const Batch& batch, std::size_t facet, const Grid& grid, const Forcing& forcing,
                 const Timeline& timeline, std::vector<double> start_k, double relative, double absolute_k) {
  System system{&batch, facet, &grid, &forcing};
  const auto n = static_cast<sunindextype>(grid.nodes());
  SUNContext raw = nullptr;
  check(SUNContext_Create(nullptr, &raw), "SUNContext_Create");
  const std::unique_ptr<std::remove_pointer_t<SUNContext>, FreeContext> context(raw);
  const std::unique_ptr<_generic_N_Vector, void (*)(N_Vector)> y(N_VMake_Serial(n, start_k.data(), raw), N_VDestroy);
  const std::unique_ptr<_generic_SUNMatrix, void (*)(SUNMatrix)> matrix(SUNBandMatrix(n, n > 1, n > 1, raw),
                                                                        SUNMatDestroy);
  const std::unique_ptr<_generic_SUNLinearSolver, int (*)(SUNLinearSolver)> linear(
      SUNLinSol_Band(y.get(), matrix.get(), raw), SUNLinSolFree);
  const std::unique_ptr<void, FreeMemory> memory(CVodeCreate(CV_BDF, raw));
  check(CVodeInit(memory.get(), right_side, timeline.start_s, y.get()), "CVodeInit");
  check(CVodeSStolerances(memory.get(), relative, absolute_k), "CVodeSStolerances");
  check(CVodeSetUserData(memory.get(), &system), "CVodeSetUserData");
  check(CVodeSetLinearSolver(memory.get(), linear.get(), matrix.get()), "CVodeSetLinearSolver");
  check(CVodeSetJacFn(memory.get(), jacobian), "CVodeSetJacFn");
  check(CVodeSetMaxNumSteps(memory.get(), 100000000), "CVodeSetMaxNumSteps");

  std::vector<double> breaks{timeline.start_s, timeline.end_s};
  for (const double t : timeline.breaks_s)
    if (t > timeline.start_s && t < timeline.end_s) breaks.push_back(t);
  std::sort(breaks.begin(), breaks.end());
  breaks.erase(std::unique(breaks.begin(), breaks.end()), breaks.end());

  OracleRun run;
  const auto record = [&] {
    run.front_k.push_back(start_k.front());
    if (batch.construction.is_sheet()) run.back_k.push_back(start_k.back());
  };
  std::size_t output = 0;
  for (; output < timeline.outputs_s.size() && timeline.outputs_s[output] <= timeline.start_s; ++output)
    if (timeline.outputs_s[output] == timeline.start_s) record();
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    system.begin_s = breaks[i];
    system.end_s = breaks[i + 1];
    if (i > 0) {
      long steps = 0;
      CVodeGetNumSteps(memory.get(), &steps);
      run.steps += steps;
      check(CVodeReInit(memory.get(), breaks[i], y.get()), "CVodeReInit");
    }
    check(CVodeSetStopTime(memory.get(), breaks[i + 1]), "CVodeSetStopTime");
    double t = breaks[i];
    while (t < breaks[i + 1]) {
      const bool inside = output < timeline.outputs_s.size() && timeline.outputs_s[output] <= breaks[i + 1];
      const double to = inside ? timeline.outputs_s[output] : breaks[i + 1];
      check(CVode(memory.get(), to, y.get(), &t, CV_NORMAL), "CVode");
      if (inside && t >= to) {
        record();
        ++output;
      }
    }
  }
  long steps = 0;
  CVodeGetNumSteps(memory.get(), &steps);
  run.steps += steps;
  return run;
}

OracleRun oracle_extrapolated(const Batch& batch, std::size_t facet, const GridRequest& request, const Forcing& forcing,
                              const Timeline& timeline, double start_k, double relative) {
  const Grids grids = make_grids(batch.construction, request);
  const auto run = [&](const Grid& grid) {
    return oracle(batch, facet, grid, forcing, timeline, std::vector<double>(grid.nodes(), start_k), relative,
                  1e-3 * relative * start_k);
  };
  OracleRun fine = run(grids.fine);
  const OracleRun coarse = run(grids.coarse);
  const auto extrapolate = [](std::vector<double>& f, const std::vector<double>& c) {
    for (std::size_t i = 0; i < f.size(); ++i) f[i] += (f[i] - c[i]) / 3.0;
  };
  extrapolate(fine.front_k, coarse.front_k);
  extrapolate(fine.back_k, coarse.back_k);
  return fine;
}

}  // namespace radiometry::heat::test
