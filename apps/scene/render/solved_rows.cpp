// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/render/solved_rows.h"

#include <algorithm>
#include <cmath>

#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "radiometry/weather/instant.h"

namespace apps::scene {

HeatRows solved_rows(const SceneFile& file, double from_s, double to_s, const HeatOptions& options,
                     const HeatProgress& progress) {
  using radiometry::heat::instant_text;
  SceneFile until = file;
  TimeSection& time = until.time;
  if (!(from_s >= time.start_s && to_s <= time.end_s))
    throw mtf::UsageError("--time: " + instant_text(from_s) + (to_s > from_s ? " to " + instant_text(to_s) : "") +
                          " is outside of the run of " + one_line(file.file) + ", which goes from " +
                          instant_text(time.start_s) + " to " + instant_text(time.end_s));
  // Two outputs at least, between which temperatures are straight lines.
  const double steps = std::max(std::ceil((to_s - time.start_s) / time.step_s), 1.0);
  time.end_s = std::min(time.start_s + steps * time.step_s, time.end_s);
  HeatRows rows;
  const HeatScene scene = prepare_heat(until, options);
  run_heat(
      scene, options,
      [&](const HeatOutput& output) {
        const double utc_s = time.start_s + output.time_s;
        if (utc_s + time.step_s < from_s) return;
        rows.utc_s.push_back(utc_s);
        rows.front.emplace_back(output.front_k.begin(), output.front_k.end());
        rows.back.emplace_back(output.back_k.begin(), output.back_k.end());
      },
      progress);
  return rows;
}

}  // namespace apps::scene
