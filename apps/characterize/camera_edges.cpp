// SPDX-License-Identifier: Apache-2.0
#include "apps/characterize/camera_edges.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "apps/characterize/pattern_planes.h"
#include "apps/edges/fit_command.h"
#include "apps/edges/fit_parameters.h"
#include "apps/sensor/sensor_air.h"
#include "apps/sensor/sensor_place.h"
#include "apps/terminal/text_table.h"
#include "mtf/error.h"
#include "mtf/io/config/config_reader.h"

namespace apps {
namespace {

using calib::Characterization, calib::Estimate, calib::Finding;

double squares_of(const Characterization& camera, std::initializer_list<const char*> names, double unit) {
  double sum = 0.0;
  for (const char* const name : names)
    if (const Finding* f = camera.find(name); f != nullptr && f->verdict != calib::Verdict::not_determined)
      sum += std::pow(unit * std::max(0.0, f->value), 2);
  return sum;
}

/// V(x) of the header, in counts^2.
std::function<double(double)> variance_of(const Characterization& camera) {
  if (const Finding* const sitf = camera.find("sitf")) {
    const double all =
        squares_of(camera, {"noise_v", "noise_h", "noise_tv", "noise_th", "noise_vh", "noise_tvh"}, 1e-3 * sitf->value);
    return [=](double) { return all; };
  }
  const double floor =
      squares_of(camera, {"read_noise", "row_noise", "column_noise", "dsnu", "fixed_row", "fixed_column"},
                 1.0 / camera.find("electrons_per_count")->value) +
      1.0 / 12.0;
  const double prnu2 = squares_of(camera, {"prnu", "prnu_row", "prnu_column"}, 1.0);
  return [=, gain = camera.transfer.gain.value, offset = camera.transfer.offset.value](double x) {
    const double signal = std::max(0.0, x - offset);
    return floor + (gain + prnu2 * signal) * signal;
  };
}

/// Counts from which on pixels are full, four standard deviations below the least mean of such a stack; else the end.
double clipped_from(const Characterization& camera, double end) {
  for (const calib::Stack& stack : camera.stacks) {
    double variance = 0.0;
    for (std::size_t part = 0; part < radiometry::kCubeParts; ++part)
      variance += std::max(0.0, stack.sums.squares.variance(part));
    if (stack.saturates) end = std::min(end, stack.sums.mean - 4.0 * std::sqrt(variance));
  }
  return end;
}

/// A number that frames and edges both tell, or that edges take from the frames.
struct SharedNumber {
  std::string name, unit;
  std::optional<Estimate> frames{}, edges{};  ///< sd 0: not known
  std::string what;
};

/// Weights the pixels of edges by V(x), where their own noise is about that.
SharedNumber share_noise(const std::function<double(double)>& variance, LoadedData& loaded) {
  std::vector<std::pair<double, calib::EdgeMeasurement*>> ratios;
  // The measurement's line of variance over value goes through those of both sides.
  const auto expected = [&](const calib::EdgeMeasurement& edge) {
    return std::sqrt(0.5 * (variance(edge.dark) + variance(edge.bright)));
  };
  for (calib::EdgeData& data : loaded.data.edges)
    if (data.start.trouble == calib::Trouble::none)
      ratios.emplace_back(data.start.noise_sd / expected(data.start), &data.start);
  SharedNumber noise{.name = "noise half way up", .unit = "counts", .what = "no edge was measured"};
  if (ratios.empty()) return noise;
  std::ranges::sort(ratios);
  const auto& [ratio, middle] = ratios[ratios.size() / 2];
  noise.frames = {expected(*middle), 0.0};
  noise.edges = {middle->noise_sd, 0.0};
  const bool alike = ratio > 0.8 && ratio < 1.25;
  noise.what = alike ? "that of the frames weights the edges" : "edges are weighted by their own";
  if (!alike)
    loaded.warnings.push_back("the noise of the edges is " + significant(ratio, 2) +
                              " of that of single frames at the same counts, as of averages, or of another gain; give "
                              "raw frames of the settings of the flat ones");
  for (const auto& [own, edge] : ratios) {
    if (!alike) break;
    edge->noise_gain = (variance(edge->bright) - variance(edge->dark)) / (edge->bright - edge->dark);
    edge->noise_sd = expected(*edge);
  }
  return noise;
}

/// Measures the edges of a picture in x, without the defects, which are those of the planes; returns how many pixels
/// these are.
std::int64_t add_picture(EdgePicture& picture, const FoundCamera& found, std::span<const PatternPlane> planes,
                         double step, int threads, LoadedData& loaded) {
  const Characterization& camera = found.camera;
  require_frame(picture.name, picture.image);
  picture.image.names.resize(1);
  picture.image.planes.resize(1);
  mtf::Image& plane = picture.image.planes.front();
  const double most = std::ldexp(1.0, found.bits) - 1.0;
  const auto linear = linear_counts(camera.transfer);
  for (std::int64_t i = 0; i < plane.size(); ++i) {
    const double count = static_cast<double>(plane.data()[i]) / step;
    if (count > most)
      throw mtf::UsageError(one_line(picture.name) + ": a count of " + significant(count, 10) +
                            ", and those of the frames end at " + significant(most, 10) +
                            "; give the edge as the camera writes its frames");
    plane.data()[i] = static_cast<float>(linear(count));
  }
  std::int64_t left_out = 0;
  const auto leave_out = [&](const std::vector<calib::Defect>& defects) {
    for (const calib::Defect& d : defects)
      if (float& pixel = plane.at(d.x, d.y); !std::isnan(pixel)) {
        pixel = std::numeric_limits<float>::quiet_NaN();
        ++left_out;
      }
  };
  const radiometry::MeanSquares& size = camera.stacks.front().sums.squares;
  if (static_cast<double>(plane.width()) == size.columns && static_cast<double>(plane.height()) == size.rows) {
    leave_out(camera.defects);
    for (const PatternPlane& pattern : planes) leave_out(pattern.squares.defects);
  } else {
    loaded.warnings.push_back(one_line(picture.name) + ": of another size than the flat frames, so defects stay in it");
  }
  if (picture.on_disk) loaded.files.push_back(picture.name);
  EdgeInput input;
  input.encoding = "linear";
  for (EdgePlane& edges : edge_planes_of(std::move(picture.image), picture.name, input)) {
    edges.options.quantum = 1.0;
    edges.options.floor = linear(0.0);
    edges.options.saturation = linear(clipped_from(camera, most));
    edges.options.sparse = true;
    add_edges(loaded, std::move(edges), 0, threads);
  }
  return left_out;
}

/// The side of crosstalk with what the frames say of it; nothing where they find none.
std::optional<calib::FitParameter> crosstalk_of(const Characterization& camera, const mtf::System<double>& system) {
  const Finding* const side = camera.find("crosstalk_side");
  const auto& list = system.list(mtf::Stage::readout);
  const auto at = std::ranges::find_if(list, [](const auto& one) { return one.component.kind() == "crosstalk"; });
  if (side == nullptr || side->verdict != calib::Verdict::determined || at == list.end()) return std::nullopt;
  return calib::FitParameter{.path = "readout[" + std::to_string(at - list.begin()) + "].side",
                             .name = at->label + ".side",
                             .unit = "",
                             .prior = std::array{side->value, side->sd}};
}

/// By the frames, and by the edges alone.
SharedNumber share_crosstalk(const LoadedData& loaded, std::vector<calib::FitParameter> parameters,
                             const calib::FitOptions& how, std::vector<std::string>& warnings) {
  const auto [value, sd] = *parameters.back().prior;
  parameters.back().prior.reset();
  SharedNumber side{
      .name = "crosstalk_side", .unit = "", .frames = Estimate{value, sd}, .what = "edges alone do not tell it"};
  const calib::FittedParameter alone = calib::fit(loaded.data, parameters, how).parameters.back();
  if (alone.knowledge != calib::Knowledge::determined) return side;
  side.edges = {alone.value, *alone.stderr_value};
  const double z = (alone.value - value) / std::hypot(sd, *alone.stderr_value);
  side.what = fixed(std::abs(z), 1) + " standard deviations apart";
  if (std::abs(z) > 4.0)
    warnings.push_back("crosstalk_side by frames and by edges: " + side.what +
                       "; charge that diffuses before it is collected (a component diffusion) blurs edges alone");
  return side;
}

void add_shared(const std::vector<SharedNumber>& numbers, CameraEdges& edges) {
  TextTable table({"shared", "by frames", "by edges", ""});
  Json list = Json::array();
  for (const SharedNumber& n : numbers) {
    const auto text = [&](const std::optional<Estimate>& e) {
      if (!e) return std::string("-");
      return (e->sd > 0.0 ? shown_with_error(e->value, e->sd) + " +- " + significant(e->sd, 2)
                          : significant(e->value, 5)) +
             (n.unit.empty() ? "" : " " + n.unit);
    };
    const auto json = [](const std::optional<Estimate>& e) {
      return e ? Json{{"value", e->value}, {"sd", e->sd > 0.0 ? Json(e->sd) : Json()}} : Json();
    };
    table.add({n.name, text(n.frames), text(n.edges), n.what});
    list.push_back(
        {{"name", n.name}, {"unit", n.unit}, {"frames", json(n.frames)}, {"edges", json(n.edges)}, {"what", n.what}});
    edges.words += (edges.words.empty() ? "" : "; ") + n.name + " " + text(n.frames) +
                   (n.edges ? " by frames, " + text(n.edges) + " by edges" : "") + " (" + n.what + ")";
  }
  edges.report["shared"] = std::move(list);
  edges.table += "\n" + table.aligned();
}

}  // namespace

CameraEdges fit_camera_edges(const FoundCamera& found, const StacksFile& stacks, std::vector<EdgePicture> pictures,
                             const std::string& destination, int threads, const std::function<bool(double)>& progress) {
  const Characterization& camera = found.camera;
  mtf::io::ConfigResult read = mtf::io::parse_config(found.sensor.text, destination, sensor_schema());
  mtf::io::cfg::require_no_errors(read.diagnostics, destination);
  mtf::io::SensorConfig& sensor = read.config;
  if (has_chain(sensor) && sensor.system.band)
    sensor.system = at_its_place(sensor, [&] { return with_electron_rate(sensor.system, load_chain(sensor)); });
  std::vector<calib::FitParameter> parameters = fit_parameters(sensor);
  const std::optional<calib::FitParameter> crosstalk = crosstalk_of(camera, sensor.system);
  if (crosstalk) parameters.push_back(*crosstalk);

  LoadedData loaded;
  loaded.data.conditions.push_back(sensor.system);
  std::int64_t left_out = 0;
  const std::vector<PatternPlane> planes = pattern_planes(camera);
  for (EdgePicture& picture : pictures) left_out += add_picture(picture, found, planes, stacks.step, threads, loaded);
  std::vector<SharedNumber> shared{share_noise(variance_of(camera), loaded)};
  if (const Finding* const gain = camera.find("electrons_per_count"))
    shared.push_back({"gain", "e- a count", Estimate{gain->value, gain->sd}, {}, "by it noise rises with the light"});
  shared.push_back({"saturation",
                    "counts",
                    Estimate{clipped_from(camera, std::ldexp(1.0, found.bits) - 1.0), 0.0},
                    {},
                    "from there on pixels of edges are clipped"});
  shared.push_back({"defects", "pixels", Estimate{static_cast<double>(left_out), 0.0}, {}, "left out of the edges"});

  calib::FitOptions how{.richer_models = true, .threads = threads, .progress = progress};
  CameraEdges edges{.fit = calib::fit(loaded.data, parameters, how)};
  calib::FitResult& fit = edges.fit;
  fit.warnings.insert(fit.warnings.begin(), loaded.warnings.begin(), loaded.warnings.end());
  how.richer_models = false;
  if (fit.status == calib::FitStatus::converged || edges.misfit()) {
    if (crosstalk) shared.push_back(share_crosstalk(loaded, parameters, how, fit.warnings));
    // Crosstalk to which the edges add nothing is known as the frames have it.
    const auto keep_known = [&](calib::FittedParameter& p) {
      if (!crosstalk || p.knowledge != calib::Knowledge::prior_only) return;
      p.knowledge = calib::Knowledge::determined;
      p.value = (*crosstalk->prior)[0];
      p.stderr_value = (*crosstalk->prior)[1];
    };
    keep_known(fit.parameters.back());
    for (calib::RicherModel& model : fit.richer_models) keep_known(model.parameters[fit.parameters.size() - 1]);
    edges.sensor_text = fitted_config(fit, sensor, loaded.files, destination);
  }
  edges.report = fit_report(fit, sensor, loaded.files);
  edges.table = fit_table(fit);
  add_shared(shared, edges);
  return edges;
}

}  // namespace apps
