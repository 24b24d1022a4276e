// SPDX-License-Identifier: Apache-2.0
#include "apps/edges/fit_data.h"

#include <algorithm>

#include "apps/arguments.h"
#include "apps/edges/edge_measure.h"
#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/config/schedule.h"
#include "mtf/io/csv/curve_samples.h"
#include "mtf/work/stop.h"

namespace apps {
namespace {

using mtf::io::SensorConfig;

/// The sensor of one image after the other; a new one only where a line of the conditions says so.
class Conditions {
 public:
  Conditions(const std::string& file, const SensorConfig& sensor) : systems_{sensor.system} {
    if (file.empty()) return;
    mtf::io::Schedule schedule = mtf::io::read_schedule(file, sensor);
    if (!schedule.settings.empty()) last_ = schedule.settings.back().frame;
    scheduled_.emplace(sensor, std::move(schedule));
  }
  /// Throws UsageError when a line is for an image that there is not.
  void require_within(std::size_t images, const std::string& file) const {
    if (last_ > static_cast<std::int64_t>(images))
      throw mtf::UsageError(one_line(file) + ": has a line for image " + std::to_string(last_) + ", there are " +
                            std::to_string(images) + "; frames count the images of the command line from 1");
  }
  /// Index of the sensor of the next image.
  std::size_t next() {
    if (scheduled_ && scheduled_->advance(++image_)) systems_.push_back(scheduled_->sensor().system);
    return systems_.size() - 1;
  }
  std::vector<mtf::System<double>> take() { return std::move(systems_); }

 private:
  std::vector<mtf::System<double>> systems_;
  std::optional<mtf::io::ScheduledSensor> scheduled_;
  std::int64_t image_ = 0, last_ = 0;
};

/// "jitter.rms" for "presample[1].rms": components by their labels.
std::string readable_name(const mtf::System<double>& system, const std::string& path) {
  for (const mtf::Stage stage : mtf::kStages)
    for (std::size_t i = 0; i < system.list(stage).size(); ++i) {
      const std::string owner = std::string(stage_name(stage)) + "[" + std::to_string(i) + "].";
      if (path.starts_with(owner)) return system.list(stage)[i].label + "." + path.substr(owner.size());
    }
  return path;
}

/// All curves of a file; `sd` for those that do not say it themselves.
void add_curves(LoadedData& loaded, const std::string& word, double sd, const std::string& unit) {
  const CurveWord parts = curve_word(word);
  for (const mtf::io::CurveSamples& samples : mtf::io::read_curve_samples(parts.file, mtf::find_unit(unit))) {
    calib::CurveData data;
    data.name = one_line(parts.file) + (samples.name.empty() ? "" : " " + samples.name);
    data.angle_deg = parts.angle_deg;
    data.unit = samples.unit;
    data.frequency = samples.frequency;
    data.mtf = samples.mtf;
    data.sd = samples.sd.empty() ? std::vector{sd} : samples.sd;
    loaded.data.curves.push_back(std::move(data));
  }
  loaded.files.push_back(parts.file);
}

void add_remarks(LoadedData& loaded, const EdgePlane& plane) {
  if (!plane.warning.empty()) loaded.warnings.push_back(plane.warning);
  loaded.warnings.insert(loaded.warnings.end(), plane.notes.begin(), plane.notes.end());
}

/// A single set of data that cannot be read is an error; of several it is left out with a warning.
template <class Load>
void load_or_leave_out(LoadedData& loaded, std::size_t sets, const Load& load) {
  try {
    load();
  } catch (const mtf::Stopped&) {
    throw;
  } catch (const mtf::Error& error) {
    if (sets == 1) throw;
    loaded.warnings.push_back(std::string(error.what()) + " (left out)");
    ++loaded.left_out;
  }
}

}  // namespace

void add_edges(LoadedData& loaded, EdgePlane made, std::size_t condition, int threads) {
  const EdgePlane& plane = loaded.planes.emplace_back(std::move(made));
  add_remarks(loaded, plane);
  std::vector<MeasuredEdge> measured = measure_plane(plane, {}, threads);
  for (MeasuredEdge& edge : measured) {
    const calib::Roi& roi = edge.edge.roi;
    loaded.data.edges.push_back({.name = one_line(plane.image) + (plane.channel.empty() ? "" : " " + plane.channel) +
                                         " " + std::to_string(roi.x) + "," + std::to_string(roi.y) + "," +
                                         std::to_string(roi.width) + "," + std::to_string(roi.height),
                                 .image = plane.plane.view(),
                                 .roi = roi,
                                 .condition = condition,
                                 .start = edge.edge,
                                 .quantum = plane.options.quantum,
                                 .saturation = plane.options.saturation,
                                 .floor = plane.options.floor});
    loaded.measured.push_back(std::move(edge));
  }
}

void add_spot(LoadedData& loaded, EdgePlane made, std::size_t condition) {
  const EdgePlane& plane = loaded.planes.emplace_back(std::move(made));
  add_remarks(loaded, plane);
  loaded.data.spots.push_back({.name = one_line(plane.image),
                               .image = plane.plane.view(),
                               .roi = {0, 0, plane.plane.width(), plane.plane.height()},
                               .condition = condition});
}

CurveWord curve_word(const std::string& word) {
  const std::size_t at = word.rfind('@');
  if (at == std::string::npos || word.find('/', at) != std::string::npos) return {word, 0.0};
  return {word.substr(0, at), number("--curve " + one_line(word) + ": the angle", word.substr(at + 1))};
}

std::vector<calib::FitParameter> fit_parameters(const SensorConfig& sensor) {
  std::vector<calib::FitParameter> parameters;
  for (const mtf::io::FitSpec& spec : sensor.fits)
    if (spec.fit)
      parameters.push_back({.path = spec.path,
                            .name = readable_name(sensor.system, spec.path),
                            .unit = spec.unit,
                            .min = spec.min,
                            .max = spec.max,
                            .prior = spec.prior});
  if (parameters.empty())
    throw mtf::UsageError(one_line(sensor.file) +
                          ": nothing to fit: write a number of a component as a table, such as\n"
                          "  rms = { value = \"8 urad\", fit = true, min = \"0 urad\", max = \"50 urad\" }");
  return parameters;
}

LoadedData load_fit_data(const FitOptions& options, const SensorConfig& sensor, int threads) {
  LoadedData loaded;
  Conditions conditions(options.conditions, sensor);
  const std::size_t images = options.input.images.size() + options.spots.size();
  const std::size_t sets = images + options.curves.size();
  conditions.require_within(images, options.conditions);
  for (const std::string& image : options.input.images) {
    const std::size_t condition = conditions.next();
    if (std::find(loaded.files.begin(), loaded.files.end(), image) != loaded.files.end())
      loaded.warnings.push_back(one_line(image) + " is given twice: its noise counts as independent");
    load_or_leave_out(loaded, sets, [&] {
      for (EdgePlane& plane : load_edge_planes(image, options.input))
        add_edges(loaded, std::move(plane), condition, threads);
      loaded.files.push_back(image);
    });
  }
  for (const std::string& image : options.spots) {
    const std::size_t condition = conditions.next();
    load_or_leave_out(loaded, sets, [&] {
      for (EdgePlane& plane : load_edge_planes(image, options.input, Regions::none))
        add_spot(loaded, std::move(plane), condition);
      loaded.files.push_back(image);
    });
  }
  for (const std::string& word : options.curves)
    load_or_leave_out(loaded, sets, [&] { add_curves(loaded, word, options.curve_sd, options.curve_unit); });
  loaded.data.conditions = conditions.take();
  return loaded;
}

}  // namespace apps
