// SPDX-License-Identifier: Apache-2.0
#include "radiometry/thermal/unit_flux.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>

#include "mtf/math/simd.h"
#include "mtf/parallel.h"

namespace radiometry::thermal {
namespace {

namespace geometry = radiometry::scene;
// Of the irradiance, relative; the radiosity, which is kept in single precision, has that times the reflectance.
constexpr double kTolerance = 1e-7;

struct AddScaled {
  template <int Bytes>
  static MTFKIT_INLINE void run(std::size_t count, float factor, const float* from, float* __restrict to) {
    for (std::size_t k = 0; k < count; ++k) to[k] += factor * from[k];
  }
};

/// The values of the surroundings at a moment.
double at_moment(const std::vector<double>& values, std::size_t first, std::size_t moment) {
  const std::size_t node = first + moment / 2;
  return moment % 2 == 0 ? values[node] : 0.5 * (values[node] + values[node + 1]);
}

constexpr std::size_t kMomentsAtOnce = 16;  // a row of the exchange is read once for them

/// What patches emit and get from outside at some moments: [patch * moments + place].
struct PatchMoments {
  std::vector<std::size_t> moment;
  std::vector<double> emitted, from_sky_and_ground, direct;
};

/// `sky`, `ground`: at a moment, W/m2.
template <class Sky, class Ground>
PatchMoments patch_moments(const PatchScene& scene, std::vector<std::size_t> moment, const Sky& sky,
                           const Ground& ground) {
  const PatchMeans& means = *scene.means;
  const std::size_t patches = scene.units->exchange.patches();
  PatchMoments some{std::move(moment), {}, {}, {}};
  some.emitted.assign(patches * some.moment.size(), 0.0);
  some.direct = some.emitted;
  for (std::size_t p = 0; p < patches; ++p)
    for (const std::size_t m : some.moment)
      some.from_sky_and_ground.push_back(means.sky[p] * sky(m) + means.ground[p] * ground(m));
  return some;
}

void solve_moments(const PatchScene& scene, const PatchMoments& some, std::span<const double> reflectance,
                   bool referred, PatchTable& table) {
  const geometry::Exchange& exchange = scene.units->exchange;
  const std::size_t patches = exchange.patches(), columns = some.moment.size();
  std::vector<double> outside(patches * columns), got(patches * columns);
  for (std::size_t p = 0; p < patches; ++p)
    for (std::size_t c = 0; c < columns; ++c) {
      const std::size_t at = p * columns + c;
      outside[at] = exchange.leaving_scale[p] * some.from_sky_and_ground[at] + some.direct[at];
    }
  const geometry::Radiosity solved = radiosity(exchange, some.emitted, reflectance, outside, kTolerance, columns);
  const std::vector<double>& j = solved.radiosity_w_m2;
  geometry::times(scene.means->seen, columns, j, got);
  for (std::size_t c = 0; c < columns; ++c) {
    const std::size_t moment = some.moment[c];
    double reference = 0.0;
    for (std::size_t p = 0; p < patches && referred; ++p)
      reference += j[p * columns + c] / static_cast<double>(patches);
    table.reference_w_m2[moment] = reference;
    for (std::size_t p = 0; p < patches; ++p) {
      const std::size_t at = p * columns + c;
      const double all = got[at] + some.from_sky_and_ground[at] + some.direct[at];
      table.shift[p * table.moments + moment] = static_cast<float>(solved.irradiance_w_m2[at] - all);
      table.radiosity[p * table.moments + moment] = static_cast<float>(j[at] - reference);
    }
  }
}

/// Calls `solve(moments)` for some of these at a time.
template <class Solve>
void for_moments(const std::vector<std::size_t>& moments, int threads, const Solve& solve) {
  mtf::parallel_for(static_cast<std::int64_t>(moments.size()), kMomentsAtOnce, threads,
                    [&](std::int64_t begin, std::int64_t end) {
                      solve(std::vector<std::size_t>(moments.begin() + begin, moments.begin() + end));
                    });
}

/// `value(i, scratch)` of `count` things.
template <class Value>
std::vector<double> of_each(std::size_t count, int threads, const Value& value) {
  std::vector<double> values(count);
  mtf::parallel_for(static_cast<std::int64_t>(count), 1024, threads, [&](std::int64_t begin, std::int64_t end) {
    std::vector<float> series;
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) values[i] = value(i, series);
  });
  return values;
}

PatchTable difference(const PatchTable& before, const PatchTable& after) {
  PatchTable change = after;
  for (std::size_t m = 0; m < change.moments; ++m) change.reference_w_m2[m] -= before.reference_w_m2[m];
  for (std::size_t e = 0; e < change.radiosity.size(); ++e) {
    change.radiosity[e] -= before.radiosity[e];
    change.shift[e] -= before.shift[e];
  }
  return change;
}

/// The largest value of a table at a receiver.
double most_of(const PatchTable& table, const Units& units, std::size_t receiver, std::vector<float>& series) {
  table.irradiance(units, receiver, series);
  const double share = PatchTable::share(units, receiver);
  double most = 0.0;
  for (std::size_t m = 0; m < table.moments; ++m)
    most = std::max(most, std::abs(share * table.reference_w_m2[m] + static_cast<double>(series[m])));
  return most;
}

PatchTable make_table(std::size_t patches, std::size_t moments) {
  return {moments, std::vector<double>(moments, 0.0), std::vector<float>(patches * moments, 0.0F),
          std::vector<float>(patches * moments, 0.0F)};
}

/// What each patch gets of the beams of all moments: [patch * moments + moment], W/m2.
std::vector<double> direct_of_patches(const PatchScene& scene, const std::vector<Beam>& beams) {
  const Units& units = *scene.units;
  const geometry::Exchange& exchange = units.exchange;
  struct Member {
    std::size_t receiver;
    const UnitSide* side;
  };
  std::vector<std::vector<Member>> members(exchange.patches());
  for_receivers(units, [&](std::size_t i, const Unit&, const UnitSide& side) {
    members[exchange.patch_of[i]].push_back({i, &side});
  });
  std::vector<double> direct(exchange.patches() * beams.size(), 0.0);
  mtf::parallel_for_each(static_cast<std::int64_t>(exchange.patches()), 4, scene.threads, [&](std::size_t p) {
    for (const Member& member : members[p]) {
      const double share = exchange.receiver_area_m2[member.receiver] / exchange.area_m2[p];
      for (std::size_t m = 0; m < beams.size(); ++m)
        direct[p * beams.size() + m] += share * direct_w_m2(*member.side, units.sun, beams[m]);
    }
  });
  return direct;
}

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
    const auto here = [&](const std::vector<double>& values) { return at_moment(values, context.batch.first, m); };
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

void PatchTable::irradiance(const Units& units, std::size_t receiver, std::vector<float>& all) const {
  const geometry::SparseRows& rows = units.exchange.rows;
  const float* own = shift.data() + units.exchange.patch_of[receiver] * moments;
  all.assign(own, own + moments);
  for (std::uint64_t e = rows.first[receiver]; e < rows.first[receiver + 1]; ++e)
    mtf::simd::run<AddScaled>(moments, static_cast<float>(rows.value[e]), radiosity.data() + rows.column[e] * moments,
                              all.data());
}

double PatchTable::share(const Units& units, std::size_t receiver) {
  const geometry::SparseRows& rows = units.exchange.rows;
  double sum = 0.0;
  for (std::uint64_t e = rows.first[receiver]; e < rows.first[receiver + 1]; ++e) sum += rows.value[e];
  return sum;
}

std::size_t PatchLight::moment_of(std::size_t moment) const {
  return std::clamp(moment, 2 * first, 2 * last) - 2 * first;
}

PatchLight make_patch_light(const Units& units, std::size_t first, std::size_t last) {
  PatchLight light{first, last, {}, {}};
  light.solar = light.longwave = make_table(units.exchange.patches(), light.moments());
  return light;
}

PatchMeans patch_means(const Units& units) {
  const geometry::Exchange& exchange = units.exchange;
  const std::size_t patches = exchange.patches();
  const std::vector<double> zero(patches, 0.0);
  PatchMeans means{zero, zero, zero, zero, {}};
  std::vector<std::vector<std::uint32_t>> members(patches);
  for_receivers(units, [&](std::size_t receiver, const Unit&, const UnitSide& side) {
    // The exchange is defined for reflectances below 1.
    const auto reflectance_of = [](double absorbed_part) { return std::min(1.0 - absorbed_part, 1.0 - 1e-9); };
    const std::uint32_t p = exchange.patch_of[receiver];
    const double weight = exchange.receiver_area_m2[receiver] / exchange.area_m2[p];
    means.sky[p] += weight * side.sky;
    means.ground[p] += weight * side.ground;
    means.solar_reflectance[p] += weight * reflectance_of(side.absorptance);
    means.long_reflectance[p] += weight * reflectance_of(side.emissivity);
    members[p].push_back(static_cast<std::uint32_t>(receiver));
  });
  for (std::vector<double>* reflectance : {&means.solar_reflectance, &means.long_reflectance})
    for (double& value : *reflectance) value = std::min(value, 1.0 - 1e-9);
  std::vector<double> row(patches);
  for (std::size_t p = 0; p < patches; ++p) {
    std::fill(row.begin(), row.end(), 0.0);
    for (const std::uint32_t i : members[p])
      for (std::uint64_t e = exchange.rows.first[i]; e < exchange.rows.first[i + 1]; ++e)
        row[exchange.rows.column[e]] += exchange.receiver_area_m2[i] / exchange.area_m2[p] * exchange.rows.value[e];
    for (std::uint32_t q = 0; q < patches; ++q)
      if (row[q] != 0.0) {
        means.seen.column.push_back(q);
        means.seen.value.push_back(row[q]);
      }
    means.seen.first.push_back(means.seen.column.size());
  }
  return means;
}

void fill_solar(const PatchScene& scene, PatchLight& light) {
  const Surroundings& s = *scene.surroundings;
  const std::size_t moments = light.moments();
  std::vector<Beam> beams(moments);
  for (std::size_t m = 0; m < moments; ++m) {
    if (at_moment(s.global_w_m2, light.first, m) <= 0.0) continue;
    // A node belongs to the interval before it where that is the one in which the sun is up.
    const std::size_t node = light.first + m / 2;
    const bool from_before = m % 2 == 0 && node > 0 && (node + 1 == s.nodes() || s.shadow_entry[node] < 0);
    beams[m] = from_before ? beam_at(s, node - 1, 1.0) : beam_at(s, node, m % 2 == 0 ? 0.0 : 0.5);
  }
  const std::vector<double> direct = direct_of_patches(scene, beams);
  std::vector<std::size_t> lit;
  for (std::size_t m = 0; m < moments; ++m)
    if (at_moment(s.global_w_m2, light.first, m) > 0.0) lit.push_back(m);
  for_moments(lit, scene.threads, [&](std::vector<std::size_t> moment) {
    PatchMoments some = patch_moments(
        scene, std::move(moment), [&](std::size_t m) { return at_moment(s.diffuse_w_m2, light.first, m); },
        [&](std::size_t m) { return at_moment(scene.ground->solar_w_m2, light.first, m); });
    for (std::size_t e = 0; e < some.direct.size(); ++e)
      some.direct[e] = direct[e / some.moment.size() * moments + some.moment[e % some.moment.size()]];
    solve_moments(scene, some, scene.means->solar_reflectance, false, light.solar);
  });
}

void fill_longwave(const PatchScene& scene, std::span<const double> emitted, PatchLight& light) {
  const Surroundings& s = *scene.surroundings;
  const std::size_t patches = scene.units->exchange.patches();
  std::vector<std::size_t> all(light.moments());
  std::iota(all.begin(), all.end(), std::size_t{0});
  for_moments(all, scene.threads, [&](std::vector<std::size_t> moment) {
    PatchMoments some = patch_moments(
        scene, std::move(moment), [&](std::size_t m) { return at_moment(s.sky_longwave_w_m2, light.first, m); },
        [&](std::size_t m) { return at_moment(scene.ground->longwave_w_m2, light.first, m); });
    for (std::size_t e = 0; e < some.emitted.size(); ++e)
      some.emitted[e] = emitted[some.moment[e % some.moment.size()] * patches + e / some.moment.size()];
    solve_moments(scene, some, scene.means->long_reflectance, true, light.longwave);
  });
}

std::vector<double> changes(const PatchScene& scene, const PatchTable& before, const PatchTable& after,
                            std::span<const std::uint32_t> receivers) {
  const PatchTable change = difference(before, after);
  const std::vector<double> some = of_each(
      receivers.size(), scene.threads,
      [&](std::size_t i, std::vector<float>& series) { return most_of(change, *scene.units, receivers[i], series); });
  std::vector<double> all(scene.units->exchange.receivers(), 0.0);
  for (std::size_t i = 0; i < some.size(); ++i) all[receivers[i]] = some[i];
  return all;
}

double largest_change(const PatchScene& scene, const PatchTable& before, const PatchTable& after,
                      std::span<const std::uint32_t> receivers) {
  const std::vector<double> all = changes(scene, before, after, receivers);
  return all.empty() ? 0.0 : *std::max_element(all.begin(), all.end());
}

double parabola_error(const PatchScene& scene, const PatchLight& light, std::span<const std::uint32_t> receivers) {
  constexpr double kOff = 1.0 / 124.7;
  const double* time_s = scene.surroundings->time_s.data() + light.first;
  const auto error_at = [&](const PatchTable& table, std::size_t place, std::vector<float>& series) {
    const std::size_t receiver = receivers[place];
    table.irradiance(*scene.units, receiver, series);
    const double share = PatchTable::share(*scene.units, receiver);
    const auto value = [&](std::size_t m) { return share * table.reference_w_m2[m] + static_cast<double>(series[m]); };
    // Of the interval before, which has no length at the begin and after a jump.
    double length = 0.0, curvature = 0.0, before = std::numeric_limits<double>::infinity(), most = 0.0;
    for (std::size_t i = 0; i < table.moments / 2; ++i) {
      if (is_jump(time_s[i], time_s[i + 1])) {
        length = 0.0;
        before = std::numeric_limits<double>::infinity();
        continue;
      }
      const double h = time_s[i + 1] - time_s[i];
      const double here = 4.0 / (h * h) * (value(2 * i) - 2.0 * value(2 * i + 1) + value(2 * i + 2));
      if (length > 0.0) {
        const double third = 2.0 * std::abs(here - curvature) / (h + length);
        const double error = kOff * third * h * length * std::sqrt(h * length);
        most = std::max(most, std::min(before, error));
        before = error;
      }
      length = h;
      curvature = here;
    }
    return most;
  };
  double sum = 0.0;
  for (const PatchTable* table : {&light.longwave, &light.solar}) {
    const std::vector<double> errors =
        of_each(receivers.size(), scene.threads,
                [&](std::size_t place, std::vector<float>& series) { return error_at(*table, place, series); });
    sum += errors.empty() ? 0.0 : *std::max_element(errors.begin(), errors.end());
  }
  return sum;
}

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
