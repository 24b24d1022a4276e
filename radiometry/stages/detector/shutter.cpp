// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/detector/shutter.h"

#include <algorithm>

namespace radiometry {
namespace {

using mtf::UsageError;

void require_times(const Shutter& shutter, double frame_time_s, std::int64_t rows) {
  if (!(shutter.line_time_s > 0.0))
    throw UsageError("shutter.line_time: missing; a rolling shutter needs the time from a row to the next");
  if (!(static_cast<double>(rows - 1) * shutter.line_time_s <= frame_time_s))
    throw UsageError("shutter.line_time = " + mtf::format_double(shutter.line_time_s) + " s: " + std::to_string(rows) +
                     " rows take longer than a frame of " + mtf::format_double(frame_time_s) +
                     " s; shorten it, or the frame rate");
}

}  // namespace

void apply_shutter(mtf::ImageView<float> frame, const Shutter& shutter, double frame_time_s, std::int64_t rows,
                   ShutterState& state, std::int64_t first_row) {
  require_valid("shutter", shutter);
  if (shutter.kind == ShutterKind::global) return;
  require_times(shutter, frame_time_s, rows);
  if (first_row < 0 || frame.height > rows || first_row > rows - frame.height)
    throw UsageError("shutter: rows " + std::to_string(first_row) + " to " +
                     std::to_string(first_row + frame.height - 1) + " of a detector of " + std::to_string(rows));
  const mtf::Image before = std::move(state.before);
  const bool first = before.size() == 0;
  if (!first && (before.width() != frame.width || before.height() != frame.height))
    throw UsageError("shutter: a frame of " + size_of(frame.width, frame.height) + " pixels after one of " +
                     size_of(before.width(), before.height()) + "; give all one size");
  state.before = mtf::Image(frame.width, frame.height);
  for (std::int64_t y = 0; y < frame.height; ++y) {
    float* row = frame.row(y);
    std::copy_n(row, frame.width, state.before.view().row(y));
    const double earlier_s = static_cast<double>(rows - 1 - first_row - y) * shutter.line_time_s;
    const double part = earlier_s / frame_time_s;  // of the frame before
    if (first || part == 0.0) continue;
    const float* other = before.view().row(y);
    for (std::int64_t x = 0; x < frame.width; ++x) {
      const double now = static_cast<double>(row[x]);
      row[x] = static_cast<float>(now + part * (static_cast<double>(other[x]) - now));
    }
  }
}

}  // namespace radiometry
