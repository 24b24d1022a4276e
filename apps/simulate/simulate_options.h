// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a simulation is asked for, by the command `mtf simulate`, a server or another language alike. Messages of errors
// name an option as the command does: that word stands beside each field.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mtf/device/device.h"
#include "radiometry/output_stage.h"

namespace apps {

struct ImagePart;

enum class NanPolicy { refuse, fill, propagate };
inline constexpr std::array kNanPolicies{std::pair{std::string_view("refuse"), NanPolicy::refuse},
                                         std::pair{std::string_view("fill"), NanPolicy::fill},
                                         std::pair{std::string_view("propagate"), NanPolicy::propagate}};

/// First and last frame of a sequence, and the step from one to the next: 0 <= first <= last <= 999999999, step >= 1.
struct FrameRange {
  std::int64_t first = 0, last = 0, step = 1;
};

/// What a run tells its caller while it works.
struct SimulateEvent {
  enum class Kind {
    share,     ///< `value`, 0 to 1, of the step `text` is done: "survey", "tiles" and "write" of an image in tiles, for
               ///< a sensor with [detector] after "range"; "frames" of a sequence
    stage,     ///< the stage `text` of one whole image took `value` ms: "read", "light", "plan", "run", "write"
    planning,  ///< `value` more values of slow components of the OTF have been made
    warning,   ///< the sentence `text`, a reason to doubt the result; RunReport::warnings has it too
    note       ///< the sentence `text`, about what was done; RunReport::notes has it too
  } kind{};
  std::string_view text{};
  double value = 0.0;
};

struct SimulateOptions {
  /// --tolerance: rms error of the mean image that is allowed, as a share of the standard deviation of the scene; in
  /// (0, 1). Without one 1e-4 (of a converter a tenth of a count), or with a warning the least that can be kept.
  std::optional<double> tolerance{};
  /// Of images that follow one another: the tolerance that was asked for gives way, with a warning, where the first
  /// image kept it and a later one cannot.
  bool loosen = false;
  NanPolicy nan = NanPolicy::refuse;  ///< --nan: pixels of the scene that are NaN or infinite
  bool measure = false;               ///< --rigor measure: the plan is chosen by timing, not by a model of cost
  /// --stage: place in the chain of a sensor with [detector] whose image is wanted; default: its end.
  std::optional<radiometry::OutputStage> stage{};
  std::optional<std::array<std::int64_t, 4>> region{};  ///< --roi: x, y, width, height in pixels of the output
  /// --memory: bytes that may be in use; a scene file (OpenEXR) then goes through in tiles. A sensor with [detector]
  /// may have no stage that needs the whole image. Sets thresholds of the C library's allocator for the whole process.
  /// Default: tiles only for an image that would not fit the machine and that can be made in tiles.
  std::optional<std::int64_t> memory{};
  bool resume = true;  ///< --resume: an output file in tiles goes on from what a stopped run left

  std::optional<FrameRange> frames{};  ///< --frames: of a sequence; default: all on disk, or those of the schedule
  /// --schedule: CSV file of parameters that change over frames (mtf/io/config/schedule.h); "" = none.
  std::string schedule{};

  /// --out: file to write, .exr, .png or .tif; of a sequence with a frame number, out.%04d.exr. "" = no file.
  std::string out{};
  std::optional<std::array<double, 2>> range{};  ///< --range: values at 0 and the largest number of PNG and TIFF
  std::vector<std::string> also_written{};  ///< files that the caller will write: none may be an input or the output
  bool keep_images = false;                 ///< one image that is written to a file is in the result too
  /// Takes the images where no file is named; without it they are in the result. Called for each frame, or for each
  /// tile of an image that goes through in tiles: from several threads at once and in no certain order.
  std::function<void(const ImagePart&)> sink{};

  /// --device: which the plan uses where that is faster; images in tiles are the processor's. Default: none.
  mtf::DeviceChoice device{};
  int threads = 0;  ///< 0 = all cores; the result does not depend on it
  /// Hears of progress: from any thread, one event at a time. What it throws ends the run; false: Cancelled.
  std::function<bool(const SimulateEvent&)> watch{};
};

}  // namespace apps
