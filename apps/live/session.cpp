// SPDX-License-Identifier: Apache-2.0
#include "apps/live/session.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/budget_table.h"
#include "apps/figures/curve_figure.h"
#include "apps/live/edits.h"
#include "apps/live/model.h"
#include "apps/sensor/otf_curves.h"
#include "apps/sensor/sensor_chain.h"
#include "apps/sensor/sensor_place.h"
#include "apps/simulate/sensor_image.h"
#include "apps/simulate/sensor_run.h"
#include "apps/text/json.h"
#include "mtf/error.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/io/csv/curve_csv.h"
#include "mtf/work/stop.h"

namespace apps::live {

/// The JSON body of a request, its values checked as they are asked for.
struct RequestBody {
  Json json;

  std::int64_t whole(const char* key, std::int64_t least, std::int64_t most, std::int64_t otherwise) const {
    const Json* found = json.find(key);
    if (!found || found->is_null()) return otherwise;
    const double value = found->is_number_integer() ? found->get<double>() : std::nan("");
    if (!(value >= static_cast<double>(least) && value <= static_cast<double>(most)))
      throw mtf::UsageError(std::string(key) + ": a whole number from " + std::to_string(least) + " to " +
                            std::to_string(most) + " belongs here");
    return found->get<std::int64_t>();
  }
  std::optional<double> number(const char* key) const {
    const Json* found = json.find(key);
    if (!found || found->is_null()) return std::nullopt;
    if (!found->is_number()) throw mtf::UsageError(std::string(key) + ": a number belongs here");
    return found->get<double>();
  }
  std::string text(const char* key, const std::string& otherwise = "") const {
    const Json* found = json.find(key);
    if (!found || found->is_null()) return otherwise;
    if (!found->is_string() || found->get<std::string>().size() > 100)
      throw mtf::UsageError(std::string(key) + ": a short text belongs here");
    return found->get<std::string>();
  }
  bool flag(const char* key) const {
    const Json* found = json.find(key);
    if (!found || found->is_null()) return false;
    if (!found->is_boolean()) throw mtf::UsageError(std::string(key) + ": true or false belongs here");
    return found->get<bool>();
  }
  std::vector<Edit> edits(const char* key) const {
    const Json* found = json.find(key);
    return found ? read_edits(*found) : std::vector<Edit>();
  }
  std::int64_t generation() const { return whole("generation", 0, std::int64_t{1} << 53, 0); }
  std::optional<double> tolerance() const {
    const auto asked = number("tolerance");
    if (asked && !(*asked > 0.0 && *asked < 1.0)) throw mtf::UsageError("--tolerance: is outside (0, 1)");
    return asked;
  }
};

namespace {

/// What cannot be done with a request that is allowed: an ordinary answer, as browsers put others on their console.
Answer refusal(const std::string& text, int status = 422) {
  const bool of_form = status == 400 || status == 404;
  return json_answer({{"error", text}, {"status", status}}, of_form ? status : 200);
}

/// The size and the ends of pixels, among their facts.
void add_pixel_facts(Json& facts, const PixelBytes& pixels) {
  facts["width"] = pixels.width;
  facts["height"] = pixels.height;
  facts["low"] = pixels.low;
  facts["high"] = pixels.high;
  facts["dark"] = pixels.dark;
  facts["bright"] = pixels.bright;
}

/// Facts and pixels in one body; `more` follows.
Answer pixels_answer(Json facts, const PixelBytes& pixels, const std::string& more = "") {
  add_pixel_facts(facts, pixels);
  std::string json = json_document(facts, -1);
  json.resize((json.size() + 3) / 4 * 4, ' ');  // the numbers begin at a multiple of their size
  const auto length = static_cast<std::uint32_t>(json.size());
  std::string body;
  body.reserve(4 + json.size() + pixels.bytes.size() + more.size());
  for (int byte = 0; byte < 4; ++byte) body += static_cast<char>((length >> (8 * byte)) & 0xffU);
  body += json;
  body += pixels.bytes;
  body += more;
  return {.type = "application/octet-stream", .body = std::make_shared<const std::string>(std::move(body))};
}

/// What the plan does not compute, with bounds.
Json left_out_json(const mtf::SensorPlan& plan) {
  Json left = Json::array();
  const auto add = [&](const mtf::PlanReport& report) {
    for (const mtf::Dropped& d : report.dropped) left.push_back({{"what", d.label}, {"bound", d.bound}});
    for (const mtf::Omission& o : report.omitted)
      left.push_back({{"what", o.what}, {"bound", o.bound}, {"saved_ms", o.saved_ms}});
  };
  add(plan.presample.report());
  if (plan.readout) add(plan.readout->report());
  if (plan.post) add(plan.post->report());
  return left;
}

/// Of a scene of which every `every`-th sample is sent.
Json scene_facts(const mtf::io::Scene& scene, int every) {
  return {{"full_width", scene.planes.front().width()},
          {"full_height", scene.planes.front().height()},
          {"every", every},
          {"step_x_um", scene.grid.step_x_um},
          {"step_y_um", scene.grid.step_y_um},
          {"quantity", std::string(mtf::io::quantity_name(scene.quantity))},
          {"unit", std::string(mtf::io::quantity_unit(scene.quantity))}};
}

using mtf::UsageError;

constexpr std::int64_t kWidest = 2048;  ///< pixels of the scene a side that a page is sent; more are left out evenly
constexpr std::size_t kMostTabs = 64;

constexpr std::array kStages{radiometry::OutputStage::radiance, radiometry::OutputStage::irradiance,
                             radiometry::OutputStage::watts,    radiometry::OutputStage::electrons,
                             radiometry::OutputStage::volts,    radiometry::OutputStage::dn,
                             radiometry::OutputStage::display};

std::optional<radiometry::OutputStage> stage_named(const std::string& name) {
  if (name.empty()) return std::nullopt;
  for (const radiometry::OutputStage stage : kStages)
    if (radiometry::output_stage_name(stage) == name) return stage;
  throw UsageError("stage: there is no output of that name");
}

/// A file in a folder of its own that goes away.
class ScratchFile {
 public:
  explicit ScratchFile(const std::string& name) {
    std::string folder = (std::filesystem::temp_directory_path() / "mtf_live_XXXXXX").string();
    if (::mkdtemp(folder.data()) == nullptr) throw mtf::RuntimeError("there is no room for temporary files");
    folder_ = folder;
    path_ = (folder_ / name).string();
  }
  ~ScratchFile() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::filesystem::path folder_;
  std::string path_;
};

/// A page names its two sides apart: "page-0" and "page-1".
std::string page_of(const std::string& tab) { return tab.substr(0, tab.rfind('-')); }

std::string word_of(NanPolicy policy) {
  for (const auto& [word, each] : kNanPolicies)
    if (each == policy) return std::string(word);
  return {};
}

/// What its reader would say of the sensor's text: warnings, and notes where both ways are usual.
Json notes_of(const mtf::io::SensorConfig& sensor) {
  Json notes = Json::array();
  const auto add = [&](const std::vector<mtf::io::Diagnostic>& diagnostics) {
    for (const mtf::io::Diagnostic& one : diagnostics)
      if (!one.error) notes.push_back((one.path.empty() ? "" : one.path + ": ") + one.text);
  };
  add(mtf::io::parse_config(sensor.text, sensor.file, sensor.schema).diagnostics);
  if (has_chain(sensor)) try {
      add(chain_warnings(sensor));
    } catch (const UsageError&) {  // a chain that cannot be is said by its frame
    }
  return notes;
}

Answer overtaken() { return refusal("a later request has overtaken this one", 409); }

}  // namespace

Session::Session(Sensor start, SceneSource scene, SessionOptions options)
    : options_(std::move(options)),
      edited_(std::move(start)),
      frames_(std::move(scene), {.nan = options_.nan, .device = options_.device, .threads = options_.threads}) {}
Session::Session(Sensor start, Space space, SessionOptions options)
    : options_(std::move(options)), edited_(std::move(start)), space_(std::move(space)), frames_(space_->drawer()) {}

FrameMaker& Session::maker(bool left) {
  constexpr std::uint64_t kFirstLeft = std::uint64_t{1} << 40;
  if (!left || !space_) return frames_;
  if (!left_) left_.emplace(space_->drawer(), kFirstLeft);
  return *left_;
}

std::shared_ptr<const KeptFrame> Session::kept(const RequestBody& request) {
  const auto id = static_cast<std::uint64_t>(request.whole("id", 0, std::int64_t{1} << 53, 0));
  auto found = frames_.kept(id);
  return found || !left_ ? found : left_->kept(id);
}

Answer Session::answer(const std::string& place, const std::string& body) {
  try {
    const RequestBody request{parsed_json(body).value_or(Json())};
    if (!request.json.is_object()) return refusal("the body of a request is a JSON object", 400);
    if (place == "start") return start();
    if (place == "model") return model(request);
    if (place == "frame") return frame(request);
    if (place == "stop") return stop(request);
    if (place == "scene") return scene(request);
    if (place == "figures") return figures(request);
    if (place == "value") return value(request);
    if (place == "file") return file(request);
    if (place == "scenefile") return scene_file(request);
    return refusal("there is no such place", 404);
  } catch (const RefusedEdit& error) {
    return json_answer(
        {{"error", error.what()}, {"status", 422}, {"refused", {{"list", error.list()}, {"index", error.index()}}}});
  } catch (const mtf::Stopped&) {
    return overtaken();
  } catch (const mtf::Error& error) {
    return refusal(error.what());
  } catch (const std::bad_alloc&) {
    return refusal("out of memory");
  }
}

Sensor Session::sensor_of(const RequestBody& request) {
  const std::vector<Edit> edits = request.edits("edits");
  const std::scoped_lock lock(edits_mutex_);
  return edited_.with(edits);
}

bool Session::is_latest(const RequestBody& request) {
  const std::string tab = request.text("tab");
  const std::int64_t generation = request.generation();
  const std::scoped_lock lock(generation_mutex_);
  if (generations_.size() >= kMostTabs && !generations_.contains(tab)) generations_.clear();
  std::int64_t& latest = generations_[tab];
  if (generation < latest) return false;
  latest = generation;
  return true;
}

void Session::begin_work(const RequestBody& request) {
  const std::scoped_lock lock(generation_mutex_);
  working_ = {request.text("tab"), request.generation()};
  stopped_ = false;
}

Answer Session::stop(const RequestBody& request) {
  const std::string tab = request.text("tab");
  const std::int64_t generation = request.generation();
  const std::scoped_lock lock(generation_mutex_);
  if (working_ == std::pair{tab, generation}) stopped_ = true;
  // One that waits for its turn, behind another page's, is overtaken by the next.
  if (const auto latest = generations_.find(tab); latest != generations_.end())
    latest->second = std::max(latest->second, generation + 1);
  return json_answer(Json::object());
}

Answer Session::start() {
  Json json{{"sensor", options_.sensor_name},    {"scene", options_.scene_name},    {"text", edited_.start()->text},
            {"before", options_.command_before}, {"tolerance", options_.tolerance}, {"numbers", frames_.numbers()},
            {"nan", word_of(options_.nan)}};
  if (space_) {
    json["space"] = space_->facts;
    json["space"]["position"] = space_->start.position_m;
    json["space"]["look_at"] = space_->start.look_at_m;
    json["space"]["utc_s"] = space_->start.utc_s;
    json["space"]["begin_s"] = space_->begin_s;
    json["space"]["end_s"] = space_->end_s;
  }
  return json_answer(json);
}

std::string Session::scene_text_of(const RequestBody& request) {
  const std::vector<Edit> edits = request.edits("scene");
  const std::scoped_lock lock(edits_mutex_);
  if (!scene_text_ || scene_edits_ != edits) {
    scene_text_ = space_->edited(edits);
    scene_edits_ = edits;
  }
  return *scene_text_;
}

Answer Session::scene_file(const RequestBody& request) {
  if (!space_) return refusal("a scene that is an image has no file with a camera");
  return json_answer({{"text", space_->with_camera(scene_text_of(request), viewpoint_of(request.json, *space_))}});
}

Answer Session::model(const RequestBody& request) {
  const Sensor sensor = sensor_of(request);
  Json json = model_json(*sensor, edited_.kinds());
  json["text"] = sensor->text;
  json["notes"] = notes_of(*sensor);
  if (space_) json["scene"] = space_->rows(scene_text_of(request));
  json["chain"] = has_chain(*sensor);
  json["stages"] = Json::array();
  // A chain that cannot be is said by its frame; the forms and the text are those of the present values all the same.
  if (has_chain(*sensor)) try {
      const SensorRun run(sensor, std::nullopt);
      const RadiometricChain* chain = run.chain();
      for (const radiometry::OutputStage stage : kStages) {
        const bool thermal = chain->loaded.sensor.settings.thermal.has_value();
        const bool photon_only = stage == radiometry::OutputStage::electrons;
        const bool thermal_only = stage == radiometry::OutputStage::watts || stage == radiometry::OutputStage::volts;
        const bool no_adc = stage == radiometry::OutputStage::dn && !chain->loaded.sensor.settings.adc;
        if (stage <= chain->stage && !(thermal ? photon_only : thermal_only) && !no_adc)
          json["stages"].push_back(std::string(radiometry::output_stage_name(stage)));
      }
    } catch (const UsageError&) {
      json["stages"] = Json::array();
    }
  return json_answer(json);
}

Answer Session::frame(const RequestBody& request) {
  const bool left = request.text("side") == "left", before = request.flag("before");
  const FrameRequest asked{.number = request.whole("number", 0, kLastNoiseFrame, 0),
                           .preview = request.flag("preview"),
                           .every = request.whole("every", 1, 8, 1),
                           .from = space_ ? std::optional(viewpoint_of(request.json, *space_)) : std::nullopt,
                           .scene = space_ ? scene_text_of(request) : "",
                           .tab = page_of(request.text("tab")),
                           .may_lag = request.flag("may_lag"),
                           .tolerance = request.tolerance(),
                           .stage = stage_named(request.text("stage"))};
  if (!is_latest(request)) return overtaken();
  const Sensor sensor = sensor_of(request);
  const std::scoped_lock lock(frame_mutex_);
  // While this request waited for its turn a later one may have come.
  if (!is_latest(request)) return overtaken();
  begin_work(request);
  const mtf::StopScope scope(&stopped_);
  const auto made = maker(left).frame(sensor, asked);
  const mtf::Image& plane = made->image.planes.front();
  const int every = asked.preview ? static_cast<int>(asked.every) : 1;  // pixels of an image that moves on
  const auto text_of = [&](const char* key) {
    const auto found = made->image.metadata.text.find(key);
    return found == made->image.metadata.text.end() ? std::string() : found->second;
  };
  Json facts{{"id", made->id},
             {"generation", request.generation()},
             {"full_width", plane.width()},
             {"full_height", plane.height()},
             {"every", every},
             {"step_x_um", made->plan->out().step_x_um},
             {"step_y_um", made->plan->out().step_y_um},
             {"number", asked.number},
             {"focal_length_mm", sensor->system.frame.focal_length_mm},
             {"quantity", text_of("mtf:quantity")},
             {"unit", text_of("mtf:units")},
             {"ms", made->ms},
             {"promised", made->plan->predicted_error},
             {"tolerance", made->plan->options.tolerance},
             {"method", made->plan->presample.report().method},
             {"merged", made->plan->presample.report().merged},
             {"left_out", left_out_json(*made->plan)},
             {"warnings", made->warnings},
             {"preview", asked.preview},
             {"correction_lags", made->correction_lags}};
  std::string radiance;
  if (made->scene) {
    facts["light_lags"] = made->light_lags;
    facts["solving"] = made->solving;
    facts["radiance_promised"] = made->radiance_promised;
    facts["closures"] = made->closures;
    facts["stages_ms"] = made->stages_ms;
    facts["utc_s"] = asked.from->utc_s;
    facts["sun"] = space_->sun(asked.from->utc_s);
    if (before) {
      PixelBytes pixels = pixel_bytes(made->scene->planes.front().view(), every, options_.threads);
      facts["before"] = scene_facts(*made->scene, every);
      add_pixel_facts(facts["before"], pixels);
      radiance = std::move(pixels.bytes);
    }
  }
  return pixels_answer(std::move(facts), pixel_bytes(plane.view(), every, options_.threads), radiance);
}

Answer Session::scene(const RequestBody& request) {
  const Sensor sensor = sensor_of(request);
  const std::scoped_lock lock(frame_mutex_);
  const auto scene = frames_.scene(sensor, request.whole("number", 0, kLastNoiseFrame, 0));
  const mtf::Image& plane = scene->planes.front();
  const auto every = static_cast<int>((std::max(plane.width(), plane.height()) + kWidest - 1) / kWidest);
  Json facts = scene_facts(*scene, every);
  facts["pitch_x_um"] = sensor->system.frame.pitch_x_um;
  facts["pitch_y_um"] = sensor->system.frame.pitch_y_um;
  return pixels_answer(std::move(facts), pixel_bytes(plane.view(), every, options_.threads));
}

Answer Session::figures(const RequestBody& request) {
  const Sensor edited = sensor_of(request);
  const double angle = request.number("angle").value_or(0.0);
  const double temperature = request.number("temperature").value_or(300.0);
  if (!(temperature >= 0.0 && temperature <= radiometry::kMostTemperature_k))
    throw UsageError("temperature: from 0 to 1e9 K");
  mtf::io::SensorConfig config = *edited;
  Json json;
  if (!config.system.is_isoplanatic() && config.system.frame.columns > 0) {
    json["over_field"] = mtf::names_over_field(config.system);
    const auto x_um = request.number("x_um"), y_um = request.number("y_um");
    const mtf::Frame<double>& frame = config.system.frame;
    const double x_px = x_um.value_or(-1.0) / frame.pitch_x_um, y_px = y_um.value_or(-1.0) / frame.pitch_y_um;
    // A place that the detector no longer has is none.
    if (x_px >= 0.0 && y_px >= 0.0 && x_px <= frame.columns && y_px <= frame.rows) {
      const mtf::FieldPoint<double> point = config.system.field_point(x_px, y_px);
      config.system = system_at(config.system, point);
      json["place"] = {{"x_px", x_px}, {"y_px", y_px}, {"x", point.x}, {"y", point.y}};
    }
  }
  if (has_chain(config) && config.system.band) {
    const LoadedSensor loaded = load_chain(config);
    const BudgetTable budget = budget_table(config, loaded, temperature);
    config.system = at_its_place(config, [&] { return with_electron_rate(config.system, loaded); });
    json["budget"] = Json::array();
    for (const radiometry::BudgetRow& row : budget.rows)
      json["budget"].push_back({{"name", row.name},
                                {"value", row.value},
                                {"unit", row.unit},
                                {"doc", row.doc},
                                {"reason", row.refused},
                                {"saturated", row.saturated}});
    json["saturation"] = words(budget.numbers.saturation);
    json["temperature"] = temperature;
  }
  const Direction direction = make_direction(config.system.frame, request.text("unit", "cy/mm"), angle);
  const OtfCurves curves = otf_curves(config.system, {}, direction);
  json["curves"] = curves_json(curves);
  json["at_nyquist"] = curves_json(otf_curves(config.system, {curves.figures.nyquist}, direction));
  json["mtf50"] = mtf50(config.system, curves);
  return json_answer(json);
}

Answer Session::value(const RequestBody& request) {
  const Sensor sensor = sensor_of(request);
  const std::scoped_lock lock(frame_mutex_);
  const auto made = kept(request);
  if (!made) return refusal("that frame is no longer kept", 410);
  const auto scene = made->scene ? made->scene : frames_.scene(sensor, request.whole("number", 0, kLastNoiseFrame, 0));
  const mtf::Image& after = made->image.planes.front();
  const mtf::Image& before = scene->planes.front();
  const double x_um = request.number("x_um").value_or(0.0), y_um = request.number("y_um").value_or(0.0);
  const auto at = [&](const mtf::Image& image, double step_x, double step_y, std::int64_t every) {
    const double x = std::floor(x_um / step_x), y = std::floor(y_um / step_y);
    const bool inside =
        x >= 0 && y >= 0 && x < static_cast<double>(image.width()) && y < static_cast<double>(image.height());
    if (!inside) return Json();
    // Where rows are without noise, the pixel that is shown in that place.
    const std::int64_t column = static_cast<std::int64_t>(x) / every * every,
                       row = static_cast<std::int64_t>(y) / every * every;
    const double number = static_cast<double>(image.at(column, row));
    return Json{{"x", column}, {"y", row}, {"value", number}};
  };
  const mtf::SampleGrid& out = made->plan->out();
  return json_answer({{"before", at(before, scene->grid.step_x_um, scene->grid.step_y_um, 1)},
                      {"after", at(after, out.step_x_um, out.step_y_um, made->noise_rows)}});
}

Answer Session::file(const RequestBody& request) {
  const std::string format = request.text("format");
  if (format != "exr" && format != "png") return refusal("format: exr or png", 400);
  std::shared_ptr<const KeptFrame> made;
  {
    const std::scoped_lock lock(frame_mutex_);
    made = kept(request);
  }
  if (!made) return refusal("that frame is no longer kept", 410);
  if (made->passing) return refusal("that picture is a preview; files are made of final pictures");
  const ScratchFile scratch("frame." + format);
  write_sensor_image(scratch.path(), made->names, made->image.planes, made->image.metadata, made->range);
  constexpr std::size_t kMost = std::size_t{1} << 31;
  return {.type = format == "png" ? "image/png" : "image/x-exr",
          .body = std::make_shared<const std::string>(mtf::io::read_file(scratch.path(), kMost))};
}

std::string error_of(const Answer& answer) {
  const std::optional<Json> json = parsed_json(*answer.body);
  return json && json->contains("error") ? json->at("error").get<std::string>() : "";
}

Answer json_answer(const Json& json, int status) {
  return {.status = status, .body = std::make_shared<const std::string>(json_document(json, -1))};
}

}  // namespace apps::live
