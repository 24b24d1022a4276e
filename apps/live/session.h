// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the live view answers. A request names a place of the list below and has a JSON body; nothing in it is a path.
// Every answer follows from the request and the files that the command was started with: the list of edits comes with
// each request, so that tabs, undo and links need no state here.
//
//   model   {"edits", "scene"}                           sensor and 3-D scene as forms, the sensor's text
//   frame   {"edits", "tab", "generation", "number", "tolerance", "stage", "preview", "every", "side"}
//           facts and pixels of the image; of a 3-D scene also "scene", edits of its file, "position", "look_at",
//           "utc_s", "may_lag", and with "before" its radiance
//   stop    {"tab", "generation"}                        that frame is not wanted, which then answers 409
//   scene   {"edits", "number"}                          facts and pixels of the scene
//   figures {"edits", "angle", "unit", "temperature", "x_um", "y_um"}    curves and budget; of a place, where given
//   value   {"id", "x", "y", "edits", "number"}          values under the cursor
//   file    {"id", "format"}                             the frame as .exr or .png
//   start   {}                                           what the page needs once
//   scenefile {"scene", "position", "look_at", "utc_s"}  the text of the 3-D scene's file with that camera

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "apps/live/edits.h"
#include "apps/live/frames.h"
#include "apps/live/model.h"
#include "apps/live/space/space.h"

namespace apps::live {

// Answers of the live view: JSON, or facts and pixels. Pixels follow their facts: four bytes with the length of the
// JSON, the JSON, the numbers of PixelBytes; of a 3-D scene those of the radiance after those of the image.

struct Answer {
  int status = 200;
  std::string type = "application/json";
  std::shared_ptr<const std::string> body = std::make_shared<const std::string>();
};

/// The message of an answer that is an error, "" of others.
std::string error_of(const Answer& answer);

Answer json_answer(const Json& json, int status = 200);

struct SessionOptions {
  std::string sensor_name{}, scene_name{};  ///< as on the command line
  std::string command_before{};             ///< what makes the files of the demo where they are missing
  std::optional<double> tolerance{};
  NanPolicy nan = NanPolicy::refuse;
  mtf::DeviceChoice device{};
  int threads = 0;
};

struct RequestBody;

class Session {
 public:
  Session(Sensor start, SceneSource scene, SessionOptions options);
  Session(Sensor start, Space space, SessionOptions options);

  /// Never throws for what is in a request: errors are answers with {"error": text, "status": 422, 409 (overtaken) or
  /// 410 (no longer kept)}. May be called from several
  /// threads; frames are made one after the other.
  Answer answer(const std::string& place, const std::string& body);
  /// Of a sequence the number of its first file, else 0.
  std::int64_t first_number() const { return frames_.numbers().empty() ? 0 : frames_.numbers().front(); }

 private:
  Answer model(const RequestBody& request);
  Answer frame(const RequestBody& request);
  Answer stop(const RequestBody& request);
  Answer scene(const RequestBody& request);
  Answer figures(const RequestBody& request);
  Answer value(const RequestBody& request);
  Answer file(const RequestBody& request);
  Answer start();
  Answer scene_file(const RequestBody& request);
  /// Makers of the pictures on the right and the left of the divider: in 3-D each has light and filters of its own.
  FrameMaker& maker(bool left);
  std::shared_ptr<const KeptFrame> kept(const RequestBody& request);
  Sensor sensor_of(const RequestBody& request);
  /// Of a 3-D scene, with the request's edits.
  std::string scene_text_of(const RequestBody& request);
  /// False for a request that a later one of its tab has overtaken.
  bool is_latest(const RequestBody& request);
  void begin_work(const RequestBody& request);

  SessionOptions options_;
  std::mutex edits_mutex_, frame_mutex_, generation_mutex_;
  EditedSensor edited_;
  std::optional<Space> space_;
  std::vector<Edit> scene_edits_{};  ///< of scene_text_
  std::optional<std::string> scene_text_{};
  FrameMaker frames_;
  std::optional<FrameMaker> left_;  ///< of a 3-D scene, once it is asked for
  std::map<std::string, std::int64_t> generations_;
  std::pair<std::string, std::int64_t> working_{};  ///< tab and generation of the last frame that was begun
  std::atomic<bool> stopped_{false};                ///< the work on it
};

}  // namespace apps::live
