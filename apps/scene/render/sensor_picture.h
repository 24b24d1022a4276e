// SPDX-License-Identifier: Apache-2.0
#pragma once

// The picture of a scene that a sensor takes in, with what a file of it says: the scene of `mtf simulate`, without
// options. Field of view and samples follow from [frame] of the sensor file; the weights from its curves.

#include <span>

#include "apps/scene/render/picture_scene.h"
#include "mtf/io/config/config.h"
#include "mtf/io/image_io.h"
#include "mtf/io/scene.h"
#include "radiometry/render/renderer.h"

namespace apps::scene {

enum class PictureQuantity {
  weighted,  ///< by the response of the sensor: photons, or W for a thermal detector
  radiance   ///< W m-2 sr-1 in the band
};

/// What a sensor file says of a picture.
struct PictureSensor {
  mtf::io::SensorConfig config{};
  radiometry::render::RenderBand band{};
  PictureQuantity quantity = PictureQuantity::weighted;
  std::string response{};                                    ///< hash; "" for plain radiance
  std::optional<radiometry::atmosphere::Air<double>> air{};  ///< [atmosphere]
  bool has_path = false;                                     ///< [path] or [atmosphere]
};

/// Throws UsageError for a sensor without a band or format, and for weighted radiance without [detector].
PictureSensor picture_sensor(const mtf::io::SensorConfig& config, PictureQuantity quantity);

/// The camera of that sensor there. Throws UsageError as radiometry::render::camera_of.
radiometry::render::Camera picture_camera(const PictureSensor& sensor, const radiometry::render::Pose& pose,
                                          double samples_per_pitch);

/// Bytes that each sample of a picture takes, measured with 4000 x 4000 of them: of a picture, more for each layer or
/// further band, more for the image that --picture shows beside it; of a frame of a flight, and of the live view.
inline constexpr double kPictureBytes = 28.0, kPlaneBytes = 8.0, kShownBytes = 38.0, kFlightBytes = 40.0,
                        kLiveBytes = 62.0;

/// What pictures need, as "pictures of 16000 x 16000 samples take about 7 GiB of memory, the machine has 23 GiB" where
/// that is more than 1 GiB, else "". Throws UsageError where it is more than may be used.
std::string memory_words(const mtf::io::SensorConfig& sensor, double samples_per_pitch, double bytes_a_sample);

/// The finest detail that the samples of a picture hold, and the largest MTF of the sensor before its sampling there,
/// along x and y. What is finer shows as false detail, weaker by the MTF at the frequency that it takes.
struct FinestDetail {
  double frequency_cy_mm = 0.0;
  double mtf = 0.0;
};
FinestDetail finest_detail(const PictureSensor& sensor, double samples_per_pitch);
/// The fewest whole samples a pitch, 2 to 8, whose finest detail none of the sensors passes more than a tenth of; 8
/// where that is not enough, with a warning then.
double samples_for(std::span<const PictureSensor> sensors);
/// Empty, or what to do where the sensor sees more of it than it should.
std::string sampling_warning(const PictureSensor& sensor, double samples_per_pitch);

/// Empty, or that the light which surfaces reflect errs by more than the noise of the sensor.
std::string reflected_warning(const PictureSensor& sensor, double error_k, int rays);

/// The pose of [camera] of a scene file, with that of options in its place. Throws UsageError where neither states one.
radiometry::render::Pose pose_of(const SceneFile& file,
                                 const std::optional<radiometry::scene::Point>& position = std::nullopt,
                                 const std::optional<radiometry::scene::Point>& look_at = std::nullopt);

/// Throws UsageError where sensors of one picture differ in their fields of view or samples, with both in numbers.
void require_same_view(std::span<const PictureSensor> sensors, std::span<const radiometry::render::Camera> cameras);

/// Attributes of the file of one band of a frame.
mtf::io::Metadata picture_metadata(const SceneFile& file, const PictureScene& scene, const PictureSensor& sensor,
                                   const radiometry::render::Camera& camera,
                                   const radiometry::render::RenderOptions& options,
                                   const radiometry::render::RenderedFrame& frame, std::size_t band = 0);

/// What mtf::io::load_scene makes of the file of a frame: its first band.
mtf::io::Scene scene_of(radiometry::render::RenderedFrame frame, const PictureSensor& sensor,
                        const radiometry::render::Camera& camera, const mtf::io::Metadata& metadata);

/// The planes of one band of a frame under their names: Y, then the layers.
std::vector<mtf::io::NamedPlane> picture_planes(const radiometry::render::RenderedFrame& frame, std::size_t band = 0);

}  // namespace apps::scene
