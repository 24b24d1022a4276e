// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/unit_flux.h"

#include <algorithm>
#include <memory>

#include "mtf/math/simd.h"

namespace radiometry::thermal {
namespace {

namespace geometry = radiometry::scene;
/// A place in the interval after a node.
struct Between {
  std::size_t node = 0;
  double share = 0.0;  ///< 0 at the node, 1 at the next
};

Between place_of(const std::vector<double>& times, heat::Instant at) {
  const bool before = at.limit == heat::Instant::Limit::before;
  const auto above = before ? std::ranges::lower_bound(times, at.time_s) : std::ranges::upper_bound(times, at.time_s);
  const auto next = std::clamp<std::ptrdiff_t>(above - times.begin(), 1, static_cast<std::ptrdiff_t>(times.size()) - 1);
  const auto node = static_cast<std::size_t>(next - 1);
  return {node, std::clamp((at.time_s - times[node]) / (times[node + 1] - times[node]), 0.0, 1.0)};
}

double between(const std::vector<double>& values, Between at) {
  return values[at.node] + at.share * (values[at.node + 1] - values[at.node]);
}

/// One side of a group of units: arrays of the units side by side.
struct SideLanes {
  std::size_t units = 0;
  std::array<std::vector<double>, 3> normal;
  std::vector<float> lit;   ///< absorptance times the share in the sun: [entry * units + unit]
  std::vector<float> rest;  ///< all but the beam, less `base`: [moment * units + unit]
  std::vector<double> base;
};

/// absorbed = base + parabola through three rows + beam
struct Absorbed {
  template <int Bytes>
  static MTFKIT_INLINE void run(std::size_t units, const double* base, const float* const* rows, const double* weights,
                                double* __restrict absorbed) {
    const auto w0 = static_cast<float>(weights[0]), w1 = static_cast<float>(weights[1]),
               w2 = static_cast<float>(weights[2]);
    const float *r0 = rows[0], *r1 = rows[1], *r2 = rows[2];
    for (std::size_t i = 0; i < units; ++i)
      absorbed[i] = base[i] + static_cast<double>(w0 * r0[i] + w1 * r1[i] + w2 * r2[i]);
  }
};
struct AddBeam {
  template <int Bytes>
  static MTFKIT_INLINE void run(std::size_t units, const double* nx, const double* ny, const double* nz,
                                const float* lit, const float* lit_next, const Beam* beam,
                                double* __restrict absorbed) {
    const double x = beam->to_sun[0], y = beam->to_sun[1], z = beam->to_sun[2], e = beam->irradiance_w_m2;
    const auto share = static_cast<float>(beam->share);
    for (std::size_t i = 0; i < units; ++i) {
      const double cosine = nx[i] * x + ny[i] * y + nz[i] * z;
      absorbed[i] += (cosine > 0.0 ? e * cosine : 0.0) * static_cast<double>(lit[i] + share * (lit_next[i] - lit[i]));
    }
  }
};

/// What all units get at the moments of a batch, W/m2: from the sky, from the ground, and of the reference of patches.
struct Moments {
  std::vector<std::size_t> in_light;  ///< the place in the tables of patches
  std::vector<double> sky_solar, sky_longwave, ground_solar, ground_longwave, reference;
};

/// What all groups of a batch share.
struct Context {
  ForcedUnits batch;
  const Units* units;
  const Surroundings* surroundings;
  const GroundLight* ground;
  const PatchLight* light;
  const Material* surface;  ///< for what is inside and in its layers
  double start_s;

  std::size_t moments() const { return 2 * (batch.last - batch.first) + 1; }
};

Moments moments_of(const Context& context) {
  const Surroundings& s = *context.surroundings;
  Moments at;
  for (std::size_t m = 0; m < context.moments(); ++m) {
    const std::size_t node = context.batch.first + m / 2;
    const auto here = [&](const std::vector<double>& values) {
      return m % 2 == 0 ? values[node] : 0.5 * (values[node] + values[node + 1]);
    };
    at.in_light.push_back(context.light->moment_of(2 * context.batch.first + m));
    at.sky_solar.push_back(here(s.diffuse_w_m2));
    at.sky_longwave.push_back(here(s.sky_longwave_w_m2));
    at.ground_solar.push_back(here(context.ground->solar_w_m2));
    at.ground_longwave.push_back(here(context.ground->longwave_w_m2));
    at.reference.push_back(context.light->longwave.reference_w_m2[at.in_light.back()]);
  }
  return at;
}

/// The first and the last entry of the table of shadows within the nodes of the batch; none: {0, -1}.
std::pair<std::size_t, std::size_t> entries_of(const Context& context) {
  const std::vector<int>& entry = context.surroundings->shadow_entry;
  std::size_t first = 0, end = 0;
  for (std::size_t k = context.batch.first; k < context.batch.last; ++k)
    if (entry[k] >= 0) {
      if (end == 0) first = static_cast<std::size_t>(entry[k]);
      end = static_cast<std::size_t>(entry[k]) + 2;
    }
  return {first, end};
}

struct GroupLanes {
  SideLanes front, back;
  std::size_t first_entry = 0;
};

SideLanes lanes_of(const Context& context, const Moments& at, const std::vector<const UnitSide*>& sides,
                   const std::vector<std::size_t>& receivers, std::pair<std::size_t, std::size_t> entries) {
  const PatchLight& light = *context.light;
  const geometry::SunVisibility& sun = context.units->sun;
  SideLanes lanes;
  const std::size_t n = lanes.units = sides.size(), moments = context.moments();
  lanes.rest.resize(moments * n);
  lanes.lit.resize((entries.second - entries.first) * n);
  lanes.base.assign(n, 0.0);
  std::vector<float> solar, longwave;
  std::vector<double> all(moments);
  for (std::size_t i = 0; i < n; ++i) {
    const UnitSide& side = *sides[i];
    for (std::size_t axis = 0; axis < 3; ++axis) lanes.normal[axis].push_back(side.normal[axis]);
    const double scale = side.absorptance / sun.points;
    for (std::size_t e = entries.first; e < entries.second; ++e)
      lanes.lit[(e - entries.first) * n + i] = static_cast<float>(scale * sun.lit[side.sun_row * sun.directions + e]);
    light.solar.irradiance(*context.units, receivers[i], solar);
    light.longwave.irradiance(*context.units, receivers[i], longwave);
    const double sky_solar = side.absorptance * side.sky, ground_solar = side.absorptance * side.ground;
    const double sky_longwave = side.emissivity * side.sky, ground_longwave = side.emissivity * side.ground;
    const double reference = side.emissivity * light.longwave.share(*context.units, receivers[i]);
    double sum = 0.0;
    for (std::size_t m = 0; m < moments; ++m)
      all[m] = side.source_w_m2 + sky_solar * at.sky_solar[m] + ground_solar * at.ground_solar[m] +
               sky_longwave * at.sky_longwave[m] + ground_longwave * at.ground_longwave[m] +
               reference * at.reference[m];
    for (std::size_t m = 0; m < moments; ++m) {
      all[m] += side.absorptance * static_cast<double>(solar[at.in_light[m]]) +
                side.emissivity * static_cast<double>(longwave[at.in_light[m]]);
      sum += all[m];
    }
    lanes.base[i] = sum / static_cast<double>(moments);
    for (std::size_t m = 0; m < moments; ++m) lanes.rest[m * n + i] = static_cast<float>(all[m] - lanes.base[i]);
  }
  return lanes;
}

void absorbed_by(const SideLanes& lanes, const Beam& beam, std::size_t first_entry, std::size_t moment, double share,
                 std::span<double> absorbed) {
  const double weights[3] = {(1.0 - share) * (1.0 - 2.0 * share), 4.0 * share * (1.0 - share),
                             share * (2.0 * share - 1.0)};
  const std::size_t n = lanes.units;
  const float* rows[3];
  for (std::size_t j = 0; j < 3; ++j) rows[j] = lanes.rest.data() + (moment + j) * n;
  mtf::simd::run<Absorbed>(n, lanes.base.data(), &rows[0], &weights[0], absorbed.data());
  if (beam.irradiance_w_m2 <= 0.0) return;
  const float* lit = lanes.lit.data() + (beam.entry - first_entry) * n;
  mtf::simd::run<AddBeam>(n, lanes.normal[0].data(), lanes.normal[1].data(), lanes.normal[2].data(), lit, lit + n,
                          &beam, absorbed.data());
}

}  // namespace

Beam beam_at(const Surroundings& s, std::size_t node, double share) {
  Beam beam;
  const int entry = s.shadow_entry[node];
  if (entry < 0) return beam;
  beam.to_sun = s.sun_between(node, share);
  beam.irradiance_w_m2 = between(s.direct_w_m2, {node, share});
  beam.entry = static_cast<std::size_t>(entry);
  const double begin = s.shadow_time_s[beam.entry], end = s.shadow_time_s[beam.entry + 1];
  const double time_s = s.time_s[node] + share * (s.time_s[node + 1] - s.time_s[node]);
  beam.share = std::clamp((time_s - begin) / (end - begin), 0.0, 1.0);
  return beam;
}

std::vector<geometry::SunCheck> sun_checks(const Surroundings& s) {
  constexpr double kApart_s = 540.0;  // nodes are at most 600 s apart, directions usually 1200 s
  std::vector<geometry::SunCheck> checks;
  double last_s = -kApart_s;
  for (std::size_t k = 0; k + 1 < s.nodes(); ++k) {
    const Beam beam = beam_at(s, k, 0.5);
    if (s.shadow_entry[k] < 0 || s.time_s[k] < last_s + kApart_s) continue;
    last_s = s.time_s[k];
    checks.push_back({beam.to_sun, beam.entry, beam.share});
  }
  return checks;
}

double direct_w_m2(const UnitSide& side, const geometry::SunVisibility& sun, const Beam& beam) {
  if (beam.irradiance_w_m2 <= 0.0) return 0.0;
  const double cosine = geometry::dot(side.normal, beam.to_sun);
  if (cosine <= 0.0) return 0.0;
  const std::uint8_t* lit = sun.lit.data() + side.sun_row * sun.directions + beam.entry;
  return beam.irradiance_w_m2 * cosine * (lit[0] + beam.share * (lit[1] - lit[0])) / sun.points;
}

heat::GroupForcing forcing_of(ForcedUnits batch, const Units& units, const Surroundings& s, const GroundLight& ground,
                              const PatchLight& light, const Material& surface, double start_s) {
  const auto context =
      std::make_shared<const Context>(Context{std::move(batch), &units, &s, &ground, &light, &surface, start_s});
  return [context](std::size_t first, std::size_t count) -> heat::Forcing {
    const auto entries = entries_of(*context);
    const Moments moments = moments_of(*context);
    std::vector<const UnitSide*> front, back;
    std::vector<std::size_t> receivers, back_receivers;
    for (std::size_t i = 0; i < count; ++i) {
      const Unit& unit = *context->batch.unit[first + i];
      front.push_back(&unit.front);
      receivers.push_back(unit.receiver);
      if (!unit.back) continue;
      back.push_back(&*unit.back);
      back_receivers.push_back(unit.back_receiver);
    }
    const auto lanes = std::make_shared<const GroupLanes>(
        GroupLanes{lanes_of(*context, moments, front, receivers, entries),
                   lanes_of(*context, moments, back, back_receivers, entries), entries.first});
    return [context, lanes](heat::Instant at, std::size_t, heat::ForcingValues& values) {
      const Surroundings& around = *context->surroundings;
      Between place = place_of(around.time_s, at);
      values.front.air_k = values.back.air_k = between(around.air_k, place);
      values.front.wind_m_s = values.back.wind_m_s = between(around.wind_m_s, place);
      values.front.vapour_pa = values.back.vapour_pa = between(around.vapour_pa, place);
      const Material& of = *context->surface;
      const double utc_s = context->start_s + at.time_s;
      if (!of.inside.value.empty()) values.inside = value_at(of.inside, utc_s);
      for (std::size_t k = 0; k < values.source_w_m3.size(); ++k)
        values.source_w_m3[k] = value_at(of.sources[k], utc_s);
      if (place.node >= context->batch.last) place = {context->batch.last - 1, 1.0};  // rounding of the last time
      if (place.node < context->batch.first) place = {context->batch.first, 0.0};
      const Beam beam = beam_at(around, place.node, place.share);
      const std::size_t moment = 2 * (place.node - context->batch.first);
      absorbed_by(lanes->front, beam, lanes->first_entry, moment, place.share, values.front.absorbed_w_m2);
      if (!values.back.absorbed_w_m2.empty())
        absorbed_by(lanes->back, beam, lanes->first_entry, moment, place.share, values.back.absorbed_w_m2);
    };
  };
}

}  // namespace radiometry::thermal
