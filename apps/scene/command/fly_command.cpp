// SPDX-License-Identifier: Apache-2.0

// `mtf fly SCENE SENSOR -o frame.%04d.png`: image after image of a 3-D scene.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <future>
#include <limits>
#include <set>

#include "apps/config_command.h"
#include "apps/scene/command/picture_options.h"
#include "apps/scene/command/read_scene.h"
#include "apps/scene/fly/flight.h"
#include "apps/scene/fly/stage_times.h"
#include "apps/scene/heat/read_temperatures.h"
#include "apps/simulate/frames/frame_names.h"
#include "apps/simulate/output_files.h"
#include "apps/simulate/simulate_parts.h"
#include "apps/terminal/interrupt.h"
#include "apps/terminal/output.h"
#include "apps/terminal/progress_line.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/engines/statistics.h"
#include "mtf/error.h"
#include "mtf/io/config/schedule.h"
#include "mtf/work/stopwatch.h"
#include "radiometry/weather/instant.h"

namespace apps {
namespace {

using namespace scene;
namespace fs = std::filesystem;

constexpr std::int64_t kAhead = 15;  // frames: light is asked for so long before it is wanted

/// Where and when frames are.
struct Course {
  const FlyCommandOptions& options;
  const SceneFile& file;
  double begin_s = 0.0;  ///< UTC of frame 0
  std::vector<std::int64_t> frames{};

  double seconds_of(std::int64_t frame) const { return static_cast<double>(frame) / options.rate_hz; }
  double utc_of(std::int64_t frame) const { return begin_s + options.speed * seconds_of(frame); }
  CameraPlace place_of(std::int64_t frame) const {
    const CameraSection& camera = *file.camera;
    return camera.path ? camera.path->at(seconds_of(frame)) : CameraPlace{camera.position_m, camera.look_at_m};
  }
};

void require_image_name(const std::string& name) {
  for (const char* ending : {".exr", ".png", ".tif", ".tiff"})
    if (name.ends_with(ending)) return;
  throw mtf::UsageError("-o: " + one_line(name) + ": frames are .exr, .png or .tif files");
}

/// The error that is being handled, with the number and time of its frame, and what is finished.
[[noreturn]] void rethrow(const Course& course, std::int64_t frame, std::size_t done) {
  const std::string where = "frame " + std::to_string(frame) + " (" + significant(course.seconds_of(frame), 6) +
                            " s of the flight, " + radiometry::heat::instant_text(course.utc_of(frame)) + "): ";
  const std::string left = done == 0   ? ""
                           : done == 1 ? "; the first frame is finished"
                                       : "; the first " + std::to_string(done) + " frames are finished";
  try {
    throw;
  } catch (const mtf::UsageError& error) {
    throw mtf::UsageError(where + error.what() + left);
  } catch (const mtf::RuntimeError& error) {
    throw mtf::RuntimeError(where + error.what() + left);
  }
}

/// All places of the path, so that no flight ends in the middle for one of them.
void require_places(const Course& course, const Flight& flight, const StopInGoodOrder& interrupt) {
  if (!course.file.camera->path) return;
  for (const std::int64_t frame : course.frames) try {
      if (interrupt.asked()) return;
      flight.require_place(course.place_of(frame));
    } catch (const mtf::Error&) {
      rethrow(course, frame, 1);
    }
}

std::vector<std::int64_t> frames_of(const FlyCommandOptions& options, const SceneFile& file) {
  if (options.frames && options.seconds)
    throw mtf::UsageError("--frames and --seconds both say how many frames there are; leave out one of them");
  if (options.frames) return frames_of(*options.frames);
  const std::optional<CameraPath>& path = file.camera->path;
  if (!options.seconds && !path)
    throw mtf::UsageError(
        "the camera stands still, so its path does not say how many frames there are: write --frames "
        "0:99 or --seconds 4");
  const double seconds = options.seconds ? *options.seconds : path->time_s.back();
  const double count = std::floor(seconds * options.rate_hz + 1e-9);
  if (!(count >= 0.0 && count < 1e7)) throw mtf::UsageError("--seconds: more than ten million frames");
  return frames_of(FrameRange{0, static_cast<std::int64_t>(count), 1});
}

std::vector<std::string> inputs_of(const FlyCommandOptions& options, const SceneFile& file,
                                   const mtf::io::SensorConfig& config) {
  std::vector<std::string> inputs = files_of(config);
  inputs.push_back(options.schedule);
  for (const std::vector<std::string>& more : {files_of(file), temperature_files(options.temperatures)})
    inputs.insert(inputs.end(), more.begin(), more.end());
  std::erase(inputs, "");
  return inputs;
}

/// No frame and no report replaces what the run reads, or each other, or is written through a link.
void require_outputs(const FlyCommandOptions& options, const std::optional<FrameNames>& names, const Course& course,
                     const std::vector<std::string>& inputs) {
  const auto is_frame = [&](const std::string& name) { return names && names->is_among(course.frames, name); };
  std::vector<std::string> outputs;
  if (!options.report.empty()) outputs.push_back(options.report);
  if (names) outputs.push_back(names->name(course.frames.front()));
  if (names && course.frames.size() > 1) outputs.push_back(names->name(course.frames.back()));
  require_writable(outputs, inputs);
  for (const std::string& input : inputs)
    if (is_frame(input))
      throw mtf::UsageError("-o: a frame would replace " + one_line(input) +
                            ", which this run reads; choose another name");
  if (!options.report.empty() && is_frame(options.report))
    throw mtf::UsageError("--report: " + one_line(options.report) + " is one of the frames; choose another name");
  if (!names) return;
  if (const std::vector<std::string> links = names->links(course.frames); !links.empty())
    throw mtf::UsageError("-o: " + one_line(links.front()) + " is a link; remove it, or choose another name");
}

/// What the flight did not do, in words.
std::vector<std::string> left_out(const PictureSource& source, const Flight& flight, const FlightFrame& last,
                                  std::size_t lights, std::size_t late) {
  const std::size_t sides = 2 * source.rays().facets().size();
  return {
      std::to_string(sides - last.sides) + " of " + std::to_string(sides) + " sides, which no frame shows",
      "light was made " + std::to_string(lights) + " times, " + std::to_string(late) + " of them while a frame waited",
      "filters were planned " + std::to_string(flight.plans_compiled()) + " times and changed " +
          std::to_string(flight.plans_updated()) + " times"};
}

/// Of the frames that were written.
struct WrittenValues {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  std::int64_t samples = 0, clamped = 0;
  std::string unit{};

  void take(const WrittenValues& frame) {
    least = std::min(least, frame.least), most = std::max(most, frame.most);
    samples += frame.samples, clamped += frame.clamped;
    if (!frame.unit.empty()) unit = frame.unit;
  }
};

WrittenValues write_frame(const SimulateOptions& options, const std::string& file,
                          const std::vector<std::string>& names, SimulatedImage& image, const IntegerRange& range) {
  WrittenValues values;
  for (const mtf::Image& plane : image.planes) {
    const mtf::Statistics s = mtf::statistics(plane.view());
    values.least = std::min(values.least, s.min), values.most = std::max(values.most, s.max);
    values.samples += plane.size();
  }
  if (const auto unit = image.metadata.text.find("mtf:units"); unit != image.metadata.text.end())
    values.unit = unit->second;
  values.clamped = deliver(options, file, names, image, range).clamped;
  return values;
}

/// The values, and what a viewer that shows whole numbers from 0 on makes of them.
std::string words(const WrittenValues& values, const FlyCommandOptions& options, const IntegerRange& range) {
  std::string text = "values " + significant(values.least, 5) + " to " + significant(values.most, 5) +
                     (values.unit.empty() ? "" : " " + values.unit);
  if (values.clamped > 0)
    text += "; " +
            mtf::format_double(
                std::round(1e4 * static_cast<double>(values.clamped) / static_cast<double>(values.samples)) / 100.0) +
            " % of the samples are clamped";
  constexpr double kVisible = 0.1;  // of the scale
  if (range.ends && !options.out.ends_with(".exr") && values.most > values.least &&
      values.most - values.least < kVisible * ((*range.ends)[1] - (*range.ends)[0]))
    text += "; on a scale from " + significant((*range.ends)[0], 5) + " to " + significant((*range.ends)[1], 5) +
            " they hardly show: --range " + significant(values.least, 5) + ":" + significant(values.most, 5) +
            ", or [agc] in the sensor file";
  return text + "\n";
}

Json json_of(const StageTimes& times, std::size_t frames, double first_ms, const Flight& flight,
             const FlightFrame& last, const std::vector<std::string>& left) {
  Json json;
  json["frames"] = frames;
  json["first_frame_ms"] = first_ms;
  json["fps"] = Json::object();
  json["stage_ms"] = Json::object();
  for (const StageTimes::Row& row : times.rows(frames - 1)) {
    json["stage_ms"][row.name] = {{"min", row.least}, {"median", row.median}, {"most", row.most}};
    if (row.name == "frame") json["fps"] = {{"median", 1e3 / row.median}, {"least", 1e3 / row.most}};
  }
  json["closures"] = Json::object(flight.closures());
  json["promised_error"] = last.promised;
  json["reflected_error_K"] = last.reflected_k;
  json["view_rays"] = last.view_rays;
  json["left_out"] = left;
  return json;
}

}  // namespace

int run_fly(const FlyCommandOptions& options, const Global& global) {
  const mtf::Stopwatch all;
  const SceneFile file = read_scene(options.scene, global);
  if (!file.camera)
    throw mtf::UsageError(one_line(file.file) +
                          ": [camera]: missing; write position and look_at, or path = \"flight.csv\"");
  const mtf::io::SensorConfig config = read_sensor(options.sensor, global);
  const std::optional<FrameNames> names = options.out.empty() ? std::nullopt : FrameNames::parse(options.out);
  if (!options.out.empty() && !names)
    throw mtf::UsageError("-o: " + one_line(options.out) +
                          ": each frame is a file; write a number into the name, as "
                          "frame.%04d.png");
  if (names) require_image_name(options.out);
  Course course{options, file, instant_of("--time", options.time).value_or(file.time.start_s)};
  course.frames = frames_of(options, file);
  const std::int64_t first = course.frames.front(), last = course.frames.back();
  for (const std::int64_t frame : {first, last}) course.place_of(frame);  // the path has them
  const mtf::io::Schedule schedule =
      options.schedule.empty() ? mtf::io::Schedule{} : mtf::io::read_schedule(options.schedule, config);
  require_one_drift(config, schedule);
  std::vector<std::string> inputs = inputs_of(options, file, config);
  inputs.insert(inputs.end(), schedule.files.begin(), schedule.files.end());
  require_outputs(options, names, course, inputs);

  const PictureSensor seen = picture_sensor(config, PictureQuantity::weighted);
  const double samples_per_pitch = options.sampling.samples_per_pitch.value_or(samples_for({&seen, 1}));
  if (const std::string text = sampling_warning(seen, samples_per_pitch); !text.empty())
    note(global, "warning: " + text);
  if (const std::string words = memory_words(config, samples_per_pitch, kFlightBytes); !words.empty())
    note(global, "note: " + words);
  StopInGoodOrder interrupt(
      "mtf: interrupted: the frame that is being made is written first; once more to stop at once\n");
  ProgressLine progress(global);
  std::optional<TemperatureRows> rows;
  const PictureOptions air{.temperatures = options.temperatures, .utc_s = course.utc_of(first), .air = !options.no_air};
  double heat_ms = 0.0;
  if (options.temperatures.empty() && !regions_to_solve(file).empty()) {
    const mtf::Stopwatch heat;
    rows = solved_rows(file, course.utc_of(first), course.utc_of(last),
                       {.tolerance_k = options.heat_tolerance_k, .threads = global.threads},
                       [&](const std::string& step, double share) { progress.update(step, share); });
    heat_ms = heat.ms();
  }
  PictureSource source(file, air, std::move(rows));
  for (const std::int64_t frame : {first, last}) try {
      source.require_temperatures_at(course.utc_of(frame));
    } catch (const mtf::Error&) {
      rethrow(course, frame, 0);
    }
  FlightOptions how{.samples_per_pitch = samples_per_pitch,
                    .render = {.points = options.sampling.points, .empty_views = true, .threads = global.threads},
                    .image = options.image,
                    .light_every_s = options.light_every_s,
                    .begin_s = course.utc_of(0),  // also of a part of a flight: the same light
                    .end_s = course.utc_of(last)};
  how.image.threads = global.threads;
  how.image.out = options.out;
  how.image.device = device_of(options.device, global);
  how.image.loosen = true;  // a frame of little contrast does not end the flight
  Flight flight(source, file, air, how);

  mtf::io::ScheduledSensor now(config, schedule), ahead(config, schedule);
  Flight::Sensor sensor, coming;
  const auto advance = [](mtf::io::ScheduledSensor& scheduled, std::int64_t frame, Flight::Sensor& to) {
    if (scheduled.advance(frame) || !to) to = std::make_shared<const mtf::io::SensorConfig>(scheduled.sensor());
  };
  std::set<std::string> said;
  StageTimes times;
  std::future<WrittenValues> writing;
  WrittenValues values;
  IntegerRange scale;
  FlightFrame frame;
  double first_ms = 0.0, loosest = 0.0;
  mtf::Stopwatch running;
  std::size_t done = 0, lights = 0, late = 0;
  for (std::size_t i = 0; i < course.frames.size() && !interrupt.asked(); ++i) {
    const std::int64_t number = course.frames[i];
    const mtf::Stopwatch whole;
    advance(now, number, sensor);
    if (i > 0) {
      const std::int64_t later =
          course.frames[std::min(i + static_cast<std::size_t>(kAhead), course.frames.size() - 1)];
      advance(ahead, later, coming);
      flight.prepare(ahead.in_force() == now.in_force() ? sensor : coming, course.utc_of(later));
    }
    try {
      frame = flight.frame(sensor, course.place_of(number), course.utc_of(number), number);
    } catch (const mtf::Error&) {
      if (writing.valid()) values.take(writing.get());
      rethrow(course, number, done);
    }
    for (const std::string& warning : frame.warnings) {
      const std::string rule = warning.substr(0, warning.find(';'));  // what breaks it changes from frame to frame
      if (said.insert(rule).second) note(global, "warning: frame " + std::to_string(number) + ": " + warning);
    }
    const mtf::Stopwatch waiting;
    if (writing.valid()) values.take(writing.get());
    scale = flight.integer_range();
    if (names)
      writing = std::async(std::launch::async, [&options, file_name = names->name(number), outputs = flight.names(),
                                                range = scale, image = std::move(frame.image)]() mutable {
        return write_frame(options.image, file_name, outputs, image, range);
      });
    ++done;
    loosest = std::max(loosest, frame.tolerance);
    lights += frame.new_light ? 1 : 0;
    if (i == 0) {
      first_ms = all.ms();
      if (writing.valid()) values.take(writing.get());
      interrupt.keep();
      require_places(course, flight, interrupt);
      running = mtf::Stopwatch();
      continue;
    }
    late += frame.late ? 1 : 0;
    for (const auto& [name, ms] : frame.timing_ms) times.add(name, ms);
    times.add("waiting for files", waiting.ms());
    times.add("frame", whole.ms());
    progress.update("frames", static_cast<double>(done) / static_cast<double>(course.frames.size()));
  }
  if (writing.valid()) values.take(writing.get());
  if (const std::string failed = device_words(how.image.device); !failed.empty()) note(global, "warning: " + failed);
  const double fps = done > 1 ? 1e3 * static_cast<double>(done - 1) / running.ms() : 0.0;
  const std::vector<std::string> left = left_out(source, flight, frame, lights, late);
  Json json = json_of(times, done, first_ms, flight, frame, left);
  json["samples_per_pitch"] = samples_per_pitch;
  json["tolerance"] = {{"asked", options.image.tolerance}, {"largest", loosest}};
  if (values.samples > 0)
    json["values"] = {{"least", values.least},
                      {"most", values.most},
                      {"unit", values.unit},
                      {"samples", values.samples},
                      {"clamped", values.clamped}};
  json.sort();
  if (!options.report.empty()) emit(options.report, json_document(json));
  if (options.format == Format::json) {
    print(json_document(json));
  } else {
    TextTable table({"ms a frame", "least", "median", "most"});
    for (const StageTimes::Row& row : times.rows(done - 1))
      table.add({row.name, significant(row.least, 3), significant(row.median, 3), significant(row.most, 3)});
    std::string text =
        done > 1 ? table.aligned({Align::left, Align::right, Align::right, Align::right}) : std::string();
    text += std::to_string(done) + (done == 1 ? " frame" : " frames") +
            (done > 1 ? ", " + significant(fps, 3) + " a second" : "") + "; the first one after " +
            significant(first_ms * 1e-3, 3) + " s" +
            (heat_ms > 0.0 ? ", of which the heat balance took " + significant(heat_ms * 1e-3, 3) + " s" : "") + "\n";
    text += "left out: " + left[0] + "; " + left[1] + "; " + left[2] + "\n";
    text += "error of the radiance: tables within " + significant(frame.promised, 2) +
            ", relative; light that surfaces reflect " + significant(1e3 * frame.reflected_k, 2) +
            " mK rms at 300 K, by " + std::to_string(frame.view_rays) + " rays a side\n";
    if (values.samples > 0) text += words(values, options, scale);
    if (names) text += "written to " + names->name(first) + " to " + names->name(course.frames[done - 1]) + "\n";
    print(text);
  }
  if (done == course.frames.size()) return 0;
  complain("mtf: interrupted: " + std::to_string(done) + " of " + std::to_string(course.frames.size()) +
           " frames are finished and whole");
  return 130;
}

}  // namespace apps
