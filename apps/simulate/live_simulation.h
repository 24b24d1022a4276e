// SPDX-License-Identifier: Apache-2.0
#pragma once

// Image after image of one scene by a sensor that changes in between: a live view, a search over parameters.
//
//   apps::LiveSimulation live({.file = "scene.exr"}, {.tolerance = 1e-3});
//   for (;;) show(live.image(sensor_with(slider.value())));
//
// Between two images only what the change asks for is done again: the scene stays in memory, in the unit that the
// sensor filters, and its transforms with it; the plan keeps its FFT plans and the components that have not changed;
// the chain of a sensor with [detector] keeps what was measured for its correction.

#include <memory>

#include "apps/simulate/sensor_image.h"
#include "apps/simulate/simulate.h"

namespace apps {

/// Whose correction the image of a sensor with [correction] has, from images after the first on.
enum class CorrectionOf {
  first_image,  ///< that of the first image: images are a sequence by one camera, whatever changes in between
  own,          ///< its own, as that of simulate(): it is measured anew where what it is measured of has changed
  earlier,      ///< quicker, while a slider moves: an earlier one, with the [vignetting] that it takes away, where
                ///< light, optics, the detector's efficiency or temporal noise alone have changed since, else its own
};

class LiveSimulation {
 public:
  /// `scene`: one image, which is read with the first image. Of the options those of one whole image count: tolerance,
  /// nan, measure, stage, threads.
  explicit LiveSimulation(SceneSource scene, const SimulateOptions& options = {});
  /// Of scenes that come with each image: image(sensor) has none. `scene` above may be without one too, for its filter.
  explicit LiveSimulation(const SimulateOptions& options) : LiveSimulation(SceneSource{}, options) {}
  ~LiveSimulation();
  LiveSimulation(LiveSimulation&&) noexcept;
  LiveSimulation& operator=(LiveSimulation&&) noexcept;

  /// The image that the sensor sees. `frame` is the number of the noise, 0 to 2147483647: the same number gives the
  /// same noise. With [lag] or a rolling [shutter] frames have to rise, as each leaves something to the next;
  /// a change of the detector grid makes them begin anew, as does one of the camera for all but
  /// CorrectionOf::first_image. Not to be called from two threads at once. Errors as simulate(); the image after a
  /// failed one is what it would be without that call. `noise_rows` = n: only rows 0, n, 2 n ... will be shown, and the
  /// others may come without noise. The method noise_rows() tells whether they did.
  SimulatedImage image(const mtf::io::SensorConfig& sensor, std::int64_t frame = 0,
                       CorrectionOf correction = CorrectionOf::first_image, std::int64_t noise_rows = 1);

  /// The image of another scene, of values in memory; that which the simulation began with stays. A sensor that is the
  /// same object as that of the image before is taken to be unchanged.
  SimulatedImage image(mtf::io::Scene scene, const std::shared_ptr<const mtf::io::SensorConfig>& sensor,
                       std::int64_t frame, CorrectionOf correction = CorrectionOf::first_image);

  /// Of the last image: its correction is an earlier one, another than its own.
  bool correction_lags() const;
  /// Of the last image: the first row and every so-many-th one after it have noise of each pixel; 1: all have.
  std::int64_t noise_rows() const;
  /// Of the last image: how it becomes whole numbers in a file.
  IntegerRange integer_range() const;
  /// Of the last image: names of its planes; reasons to doubt it; its plan, with the promise that it keeps.
  const std::vector<std::string>& names() const;
  const std::vector<std::string>& warnings() const;
  const mtf::SensorPlan& plan() const;
  /// Bytes that are kept of the scene's transforms: about as many as of its planes, more with borders other than
  /// reflect (mtf/engines/kept_scene.h). None of scenes that come with each image.
  std::int64_t kept_bytes() const;
  /// Plans made anew and plans remade in part, of all images so far.
  int plans_compiled() const;
  int plans_updated() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace apps
