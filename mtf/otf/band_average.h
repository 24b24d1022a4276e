// SPDX-License-Identifier: Apache-2.0
#pragma once

// The average of a product of chromatic components over the band, at any frequencies, to kBandError. Included by
// system_impl.h alone.
//
// At each frequency the band is split at the wavelengths of the kinks (mtf/band.h). On every part the number of
// wavelengths is doubled until the integral stands still; the last change is what the average is said to err by. It is
// that of the rule with half as many wavelengths, so the error is smaller by far.

#include <cmath>
#include <limits>
#include <numeric>

#include "mtf/math/special.h"
#include "mtf/system.h"

namespace mtf::detail {

/// Wavelengths times frequencies of the kinks of all components, um cycles/mm.
template <class S>
std::vector<double> chromatic_kinks(const System<S>& system, std::span<const Component<S>* const> chromatic) {
  const Context<S> middle = system.context();
  std::vector<double> kinks;
  for (const Component<S>* component : chromatic)
    for (const double f : component->kinks_cy_mm(middle)) kinks.push_back(f * value_of(middle.wavelength_um));
  return kinks;
}

/// sum[i] += weight x product at f[i], over the given wavelengths.
template <class S>
void add_nodes(const System<S>& system, std::span<const Component<S>* const> chromatic, const WavelengthNodes& nodes,
               std::span<const Freq<S>> f, std::vector<Complex<S>>& node, std::vector<Complex<S>>& sum) {
  for (std::size_t w = 0; w < nodes.weight.size(); ++w) {
    const Context<S> ctx = system.context(S(nodes.wavelength_um[w]));
    node.assign(f.size(), Complex<S>{S(nodes.weight[w]), S(0)});
    for (const Component<S>* component : chromatic) component->multiply(f, ctx, node);
    for (std::size_t i = 0; i < f.size(); ++i) sum[i] = sum[i] + node[i];
  }
}

/// Adds the integral over a part of the band at the frequencies `which` to `mean`, that of 1 to `weight`.
template <class S>
void add_part(const System<S>& system, std::span<const Component<S>* const> chromatic, double begin_um, double end_um,
              double allowed, std::vector<std::size_t> which, std::span<const Freq<S>> f, Averaged<S>& mean,
              std::vector<double>& weight) {
  constexpr int kFewest = 8, kMost = 1024;
  std::vector<Freq<S>> open;
  std::vector<Complex<S>> before, now, node;
  for (int n = kFewest; !which.empty(); n *= 2) {
    open.clear();
    for (const std::size_t i : which) open.push_back(f[i]);
    now.assign(open.size(), Complex<S>{S(0), S(0)});
    const WavelengthNodes nodes = part_nodes(*system.band, begin_um, end_um, n);
    const double share = std::accumulate(nodes.weight.begin(), nodes.weight.end(), 0.0);
    add_nodes<S>(system, chromatic, nodes, open, node, now);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < which.size(); ++i) {
      const double change = n == kFewest ? std::numeric_limits<double>::infinity()
                                         : std::hypot(value_of(now[i].re) - value_of(before[i].re),
                                                      value_of(now[i].im) - value_of(before[i].im));
      if (!(change <= allowed) && n < kMost) {
        which[kept] = which[i];
        now[kept++] = now[i];
        continue;
      }
      mean.value[which[i]] = mean.value[which[i]] + now[i];
      mean.error[which[i]] += change;
      weight[which[i]] += share;
    }
    which.resize(kept);
    before.swap(now);
  }
}

template <class S>
Averaged<S> band_average(const System<S>& system, std::span<const Component<S>* const> chromatic,
                         std::span<const Freq<S>> f) {
  Averaged<S> mean{std::vector<Complex<S>>(f.size(), {S(0), S(0)}), std::vector<double>(f.size(), 0.0)};
  if (system.band_nodes > 0) {
    std::vector<Complex<S>> node;
    add_nodes<S>(system, chromatic, wavelength_nodes(*system.band, system.band_nodes), f, node, mean.value);
    mean.error.assign(f.size(), std::numeric_limits<double>::quiet_NaN());
    return mean;
  }
  constexpr bool kFloat = std::is_same_v<S, float>;
  constexpr double kAllowed = kFloat ? 1e-6 : kBandError;
  const std::vector<double> kinks = chromatic_kinks(system, chromatic);
  std::vector<double> wavelengths, weight(f.size(), 0.0);
  std::vector<std::size_t> whole;  // frequencies without a kink in the band share their wavelengths
  for (std::size_t i = 0; i < f.size(); ++i) {
    const double radius = std::hypot(value_of(f[i].x), value_of(f[i].y));
    wavelengths.clear();
    for (const double kink : kinks) wavelengths.push_back(kink / radius);
    const std::vector<double> ends = parts_of(*system.band, wavelengths);
    if (ends.size() == 2) {
      whole.push_back(i);
      continue;
    }
    const double allowed = kAllowed / static_cast<double>(ends.size() - 1);
    for (std::size_t part = 0; part + 1 < ends.size(); ++part)
      add_part<S>(system, chromatic, ends[part], ends[part + 1], allowed, {i}, f, mean, weight);
  }
  add_part<S>(system, chromatic, system.band->lo_um, system.band->hi_um, kAllowed, std::move(whole), f, mean, weight);
  // A curve as narrow as a line is known to fewer digits than 1e-12: the mean of 1 is 1 all the same.
  for (std::size_t i = 0; i < f.size(); ++i) {
    if constexpr (kFloat) {
      const auto scale = static_cast<float>(1.0 / weight[i]);
      mean.value[i] = {mean.value[i].re * scale, mean.value[i].im * scale};
    } else {
      const S scale(1.0 / weight[i]);
      mean.value[i] = {mean.value[i].re * scale, mean.value[i].im * scale};
    }
  }
  return mean;
}

}  // namespace mtf::detail
