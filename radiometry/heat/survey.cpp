// SPDX-License-Identifier: Apache-2.0
#include "radiometry/heat/survey.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "radiometry/heat/surface_loss.h"

namespace radiometry::heat {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kMostSamples = 128;
constexpr std::size_t kFacetsAtOnce = 256;

/// The stops in the timeline, once each, thinned to at most `kMostSamples`.
std::vector<double> stops_of(const Timeline& timeline) {
  std::vector<double> stops{timeline.start_s, timeline.end_s};
  for (const auto* list : {&timeline.outputs_s, &timeline.breaks_s})
    for (const double t : *list)
      if (t > timeline.start_s && t < timeline.end_s) stops.push_back(t);
  std::sort(stops.begin(), stops.end());
  stops.erase(std::unique(stops.begin(), stops.end()), stops.end());
  return stops;
}

/// The shortest time from the start or a break to the next output.
double shortest_lag(const Timeline& timeline) {
  double lag = timeline.end_s - timeline.start_s;
  std::vector<double> breaks = timeline.breaks_s;
  std::sort(breaks.begin(), breaks.end());
  for (const double output : timeline.outputs_s) {
    if (output <= timeline.start_s || output > timeline.end_s) continue;
    const auto before = std::lower_bound(breaks.begin(), breaks.end(), output);
    const double since = before == breaks.begin() ? timeline.start_s : std::max(*(before - 1), timeline.start_s);
    lag = std::min(lag, output - since);
  }
  return std::max(lag, timeline.least_lag_s);
}

std::vector<Instant> sample_instants(const std::vector<double>& stops) {
  const std::size_t stride = 1 + stops.size() / (kMostSamples / 4);
  std::vector<Instant> instants;
  for (std::size_t i = 0; i + 1 < stops.size(); i += stride) {
    if (i > 0) instants.push_back({stops[i], Instant::Limit::before});
    instants.push_back({stops[i], Instant::Limit::after});
    for (const double part : {0.25, 0.5, 0.75})
      instants.push_back({stops[i] + part * (stops[std::min(i + stride, stops.size() - 1)] - stops[i])});
  }
  instants.push_back({stops.back(), Instant::Limit::before});
  return instants;
}

/// What a surface gains at an instant when it has a temperature; an inside temperature acts through all layers.
struct Gain {
  const Construction* construction;
  const ForcingValues* values;
  std::size_t facet;
  double up;

  double side(const SideForcing& from, bool back, double t) const {
    return from.absorbed_w_m2[facet] - surface_loss(*construction, back, from, back ? -up : up).at(t).loss;
  }
  double at(double t) const {
    double sum = side(values->front, false, t);
    if (construction->is_sheet()) sum += side(values->back, true, t);
    const double through = resistance(*construction);
    if (const auto* film = std::get_if<InnerFilm>(&construction->inside))
      sum += film->h_w_m2_k / (1.0 + film->h_w_m2_k * through) * (values->inside - t);
    if (std::holds_alternative<FixedTemperature>(construction->inside)) sum += (values->inside - t) / through;
    if (std::holds_alternative<InnerFlux>(construction->inside)) sum += values->inside;
    for (std::size_t i = 0; i < values->source_w_m3.size(); ++i)
      sum += values->source_w_m3[i] * construction->layers[i].thickness_m;
    return sum;
  }
};

constexpr double kHottest_k = 1e4;

/// The temperature at which nothing is gained, within 0.1 K; the gain falls with the temperature.
double balance_temperature(const Gain& gain) {
  double lo = 0.0, hi = kHottest_k;
  while (hi - lo > 0.1) {
    const double middle = 0.5 * (lo + hi);
    (gain.at(middle) > 0.0 ? lo : hi) = middle;
  }
  return 0.5 * (lo + hi);
}

}  // namespace

Survey survey(const Batch& batch, const GroupForcing& forcing, const Timeline& timeline, double start_k) {
  const std::vector<double> stops = stops_of(timeline);
  const std::vector<Instant> instants = sample_instants(stops);
  const bool sheet = batch.construction.is_sheet();
  Survey result{.lowest_w_m2 = std::vector<double>(batch.facets, kInfinity),
                .highest_w_m2 = std::vector<double>(batch.facets, -kInfinity),
                .coldest_k = std::isnan(start_k) ? kInfinity : start_k,
                .hottest_k = std::isnan(start_k) ? -kInfinity : start_k,
                .flux_w_m2 = 0.0,
                .shortest_lag_s = shortest_lag(timeline)};
  std::vector<double> front(kFacetsAtOnce), back(kFacetsAtOnce);
  std::vector<double> source(batch.construction.generates ? batch.construction.layers.size() : 0);
  // Twice over the samples: the range of temperatures, then the largest net flux within it.
  for (const bool flux : {false, true})
    for (std::size_t first = 0; first < batch.facets; first += kFacetsAtOnce) {
      const std::size_t count = std::min(kFacetsAtOnce, batch.facets - first);
      const Forcing own = forcing(first, count);
      for (const Instant instant : instants) {
        ForcingValues values;
        values.front.absorbed_w_m2 = {front.data(), count};
        if (sheet) values.back.absorbed_w_m2 = {back.data(), count};
        values.source_w_m3 = source;
        own(instant, first, values);
        // A few facets stand for all of the piece: the extremes of the absorbed flux.
        std::size_t least = 0, most = 0;
        for (std::size_t i = 0; i < count; ++i) {
          const double absorbed = front[i] + (sheet ? back[i] : 0.0);
          result.lowest_w_m2[first + i] = std::min(result.lowest_w_m2[first + i], absorbed);
          result.highest_w_m2[first + i] = std::max(result.highest_w_m2[first + i], absorbed);
          if (front[i] < front[least]) least = i;
          if (front[i] > front[most]) most = i;
        }
        for (const std::size_t i : {least, most}) {
          const Gain gain{&batch.construction, &values, i, batch.up.empty() ? 0.0 : batch.up[first + i]};
          if (flux) {
            for (const double t : {result.coldest_k, result.hottest_k})
              result.flux_w_m2 = std::max(result.flux_w_m2, std::abs(gain.at(t)));
          } else {
            const double t = balance_temperature(gain);
            result.coldest_k = std::min(result.coldest_k, t);
            result.hottest_k = std::max(result.hottest_k, t);
          }
        }
      }
    }
  return result;
}

std::size_t block_to_try(const Survey& survey, std::size_t block) {
  std::size_t best = 0;
  double most = -kInfinity;
  for (std::size_t i = 0; i < survey.highest_w_m2.size(); ++i) {
    const double change = survey.highest_w_m2[i] - survey.lowest_w_m2[i];
    if (change > most) {
      most = change;
      best = i;
    }
  }
  return best - best % block;
}

}  // namespace radiometry::heat
