// SPDX-License-Identifier: Apache-2.0
#include "radiometry/weather/value_schedule.h"

#include <algorithm>
#include <cmath>

#include "mtf/error.h"
#include "radiometry/weather/instant.h"

namespace radiometry::heat {

Schedule make_schedule(std::string source, std::vector<double> time_s, std::vector<double> value) {
  const auto refuse = [&](const std::string& why) { throw mtf::UsageError(source + ": " + why); };
  if (value.empty() || value.size() != time_s.size())
    refuse(std::to_string(time_s.size()) + " times for " + std::to_string(value.size()) +
           " values; a schedule needs at least one, each with its time");
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (!std::isfinite(time_s[i]) || !std::isfinite(value[i])) refuse("a time or a value that is not finite");
    if (i > 0 && !(time_s[i] > time_s[i - 1]))
      refuse("the time " + instant_text(time_s[i]) + " is not after the one before it; sort the samples");
  }
  return {std::move(source), std::move(time_s), std::move(value)};
}

Schedule constant_schedule(double value) { return make_schedule("constant", {0.0}, {value}); }

double value_at(const Schedule& schedule, double utc_s) {
  const auto& t = schedule.time_s;
  const auto& v = schedule.value;
  const auto after = static_cast<std::size_t>(std::upper_bound(t.begin(), t.end(), utc_s) - t.begin());
  if (after == 0) return v.front();
  if (after == t.size()) return v.back();
  return std::lerp(v[after - 1], v[after], (utc_s - t[after - 1]) / (t[after] - t[after - 1]));
}

std::vector<double> break_times(const Schedule& schedule, double begin_s, double end_s) {
  const auto& t = schedule.time_s;
  const auto first = std::upper_bound(t.begin(), t.end(), begin_s);
  const auto last = std::lower_bound(first, t.end(), end_s);
  return {first, std::max(first, last)};
}

}  // namespace radiometry::heat
