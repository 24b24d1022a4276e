// SPDX-License-Identifier: Apache-2.0
#pragma once

// Image after image of a 3-D scene while everything may change: temperatures, sun and sky with the time, the place of
// the camera, and any parameter of the sensor.
//   scene, temperatures --PictureSource--> surfaces, sky, sun, air --Renderer--> radiance --LiveSimulation--> image
// Only what has changed is done again. The light of sky, sun, ground and of what surfaces give each other is worked out
// once for `light_every_s` of the scene's clock, for the middle of that time, and anew for another band or another air.
// Temperatures of surfaces, which are seen at once, are taken anew once the clock has moved by `temperatures_every_s`.
// Of the sensor, plan and chain are made anew where a parameter is another one (LiveSimulation). Sides that were never
// seen before get their views.
// New light is made in the background where prepare() says in time that it will be wanted; without it frames are the
// same within the promise of their tables. Where somebody turns the clock by hand, frames may have the light of another
// time until the one of theirs is there (FrameChoice::light_may_lag).

#include <atomic>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "apps/scene/render/sensor_picture.h"
#include "apps/simulate/live_simulation.h"

namespace apps::scene {

struct FlightOptions {
  double samples_per_pitch = 2.0;
  radiometry::render::RenderOptions render{};  ///< without layers
  SimulateOptions image{};                     ///< those of LiveSimulation
  double light_every_s = 60.0, temperatures_every_s = 1.0;
  double begin_s = 0.0, end_s = 0.0;  ///< UTC, of the first and the last frame; others are refused
  /// FlightFrame::radiance is wanted; and frames that see the same as the one before take its radiance.
  bool keep_radiance = false;
};

/// Of one frame.
struct FrameChoice {
  /// In place of those of the flight; plans of two pairs of them are kept.
  std::optional<double> samples_per_pitch{};
  std::optional<int> points{};  ///< of a sample (RenderOptions)
  /// The light of the frame before will do, where it is of another time alone: the present one is made in the
  /// background, and frames take it once it is there.
  bool light_may_lag = false;
  CorrectionOf correction = CorrectionOf::first_image;
  /// Ends the sensor's part of the frame, which can be begun again at no loss. Where it is given nothing else of the
  /// frame is ended (mtf/work/stop.h): views of the scene that are half worked out would be those of no scene.
  const std::atomic<bool>* stop_image = nullptr;
};

struct FlightFrame {
  SimulatedImage image;
  std::vector<std::string> warnings{};
  std::vector<std::pair<std::string, double>> timing_ms{};
  double promised = 0.0;     ///< relative error of the radiance (RenderedFrame)
  double reflected_k = 0.0;  ///< error of the light that surfaces reflect (RenderedFrame)
  int view_rays = 0;
  double tolerance = 0.0;                    ///< of the filters, which the image keeps
  std::size_t sides = 0, shaded = 0;         ///< seen so far; worked out for this frame
  bool new_light = false, late = false;      ///< light was made anew; and not ready before the frame
  bool light_lags = false;                   ///< its light is of another time
  bool correction_lags = false;              ///< as LiveSimulation::correction_lags
  std::optional<mtf::io::Scene> radiance{};  ///< what the sensor took in (FlightOptions::keep_radiance)
};

class Flight {
 public:
  using Sensor = std::shared_ptr<const mtf::io::SensorConfig>;

  /// `source` outlives it. `air`: as PictureOptions of one picture.
  Flight(PictureSource& source, const SceneFile& file, const PictureOptions& air, const FlightOptions& options);
  ~Flight();

  /// Begins to make the light of that time and sensor, where it differs from the last frame's and none is made yet.
  void prepare(const Sensor& sensor, double utc_s);
  /// Begins to work out, in the background, the views of the sides that are seen from these places, so that a camera
  /// which goes there later does not wait for them. Places that see nothing, or where no camera can be, are passed
  /// over. The next frame ends it, and has what has been worked out by then; it is the same without. Does nothing while
  /// light is being made, and for places that were seen in this light.
  void look_ahead(std::span<const CameraPlace> places);
  /// `number`: of the frame, which is that of the noise. Sensors that are the same object are taken to be unchanged.
  /// Throws mtf::UsageError as picture_sensor, PictureSource::at, Renderer::render and LiveSimulation::image.
  FlightFrame frame(const Sensor& sensor, const CameraPlace& place, double utc_s, std::int64_t number,
                    const FrameChoice& choice = {});
  /// Other options of the images from here on.
  void set_image(const SimulateOptions& options);

  /// Throws as frame() would, with the sensor of the last frame, for a camera that stands below the ground or inside a
  /// solid, or has no line of sight. Once there was a frame.
  void require_place(const CameraPlace& place) const;

  const std::vector<std::pair<std::string, std::string>>& closures() const;  ///< of the last frame
  IntegerRange integer_range() const;
  const std::vector<std::string>& names() const;
  const mtf::SensorPlan& plan() const;  ///< of the last frame
  int plans_compiled() const;
  int plans_updated() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace apps::scene
