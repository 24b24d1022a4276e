// SPDX-License-Identifier: Apache-2.0
#pragma once

// When the rows of a frame are exposed. A global shutter exposes all at once, a rolling one each row a line time after
// the one above it. The time of the frame is that of its last row, so that row y of H shows the scene
//   (H - 1 - y) x line time
// earlier, on the straight line between this frame and the one before. So a rolling frame of a moving scene is sheared.
// The first frame, or a single one, has no frame before it and is left as it is. (Liang, Chang and Chen, IEEE Trans.
// Image Process. 17, 1323 (2008).)

#include "mtf/image.h"
#include "radiometry/fields.h"

namespace radiometry {

enum class ShutterKind { global, rolling };
inline constexpr std::array<std::string_view, 2> kShutterKindNames{"global", "rolling"};
constexpr std::span<const std::string_view> words(ShutterKind) { return kShutterKindNames; }

struct Shutter {
  ShutterKind kind = ShutterKind::global;
  double line_time_s = 0.0;

  static constexpr auto fields() {
    return std::tuple{
        required(&Shutter::kind, "kind", "\"rolling\"", "global, or rolling"),
        optional(&Shutter::line_time_s, "line_time", "s", 0.0, 1e6, "\"30 us\"", "rolling: from a row to the next")};
  }
};

/// The frame before, of one region of the detector; a new state has none.
struct ShutterState {
  mtf::Image before;
};

/// Replaces frames of the scene by frames of the shutter, one after another. `rows` is the height of the detector,
/// `first_row` the detector's row of the frame's first one. A NaN in either frame is NaN where both take part. Throws
/// UsageError for values out of their bounds, a rolling shutter without a line time or whose rows take longer than a
/// frame, rows outside of the detector, a frame of another size than the one before.
void apply_shutter(mtf::ImageView<float> frame, const Shutter& shutter, double frame_time_s, std::int64_t rows,
                   ShutterState& state, std::int64_t first_row = 0);

}  // namespace radiometry
