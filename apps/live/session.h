// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the live view answers. A request names a place of the list below and has a JSON body; nothing in it is a path.
// Every answer follows from the request and the files that the command was started with: the list of edits comes with
// each request, so that tabs, undo and links need no state here.
//
//   model   {"edits"}                                    the sensor as forms, its text, the command line
//   frame   {"edits", "tab", "generation", "number", "tolerance", "stage", "every"}   facts and pixels of the image
//   scene   {"edits", "number"}                          facts and pixels of the scene
//   figures {"edits", "angle", "unit", "temperature"}    curves and budget
//   value   {"id", "x", "y", "edits", "number"}          values under the cursor
//   file    {"id", "format"}                             the frame as .exr or .png
//   start   {}                                           what the page needs once
//
// Pixels follow their facts: four bytes with the length of the JSON, the JSON, the numbers of PixelBytes.

#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "apps/live/edits.h"
#include "apps/live/frames.h"

namespace apps::live {

struct Answer {
  int status = 200;
  std::string type = "application/json";
  std::shared_ptr<const std::string> body = std::make_shared<const std::string>();
};

/// The message of an answer that is an error, "" of others.
std::string error_of(const Answer& answer);

struct SessionOptions {
  std::string sensor_name, scene_name;  ///< as on the command line
  std::string command_before;           ///< what makes the files of the demo: "mtf demo && "
  std::optional<double> tolerance{};
  int threads = 0;
};

class Session {
 public:
  Session(Sensor start, SceneSource scene, SessionOptions options);

  /// Never throws for what is in a request: errors are answers with {"error": text, "status": 422, 409 (overtaken) or
  /// 410 (no longer kept)}. May be called from several
  /// threads; frames are made one after the other.
  Answer answer(const std::string& place, const std::string& body);
  /// Of a sequence the number of its first file, else 0.
  std::int64_t first_number() const { return frames_.numbers().empty() ? 0 : frames_.numbers().front(); }

 private:
  struct Parts;
  Answer model(const Parts& request);
  Answer frame(const Parts& request);
  Answer scene(const Parts& request);
  Answer figures(const Parts& request);
  Answer value(const Parts& request);
  Answer file(const Parts& request);
  Answer start();
  Sensor sensor_of(const Parts& request);
  /// False for a request that a later one of its tab has overtaken.
  bool is_latest(const Parts& request);

  SessionOptions options_;
  std::mutex edits_mutex_, frame_mutex_, generation_mutex_;
  EditedSensor edited_;
  FrameMaker frames_;
  std::map<std::string, std::int64_t> generations_;
};

}  // namespace apps::live
