// SPDX-License-Identifier: Apache-2.0

// `mtf live [SENSOR SCENE]`: the live view in the browser.

#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <future>
#include <memory>
#include <mutex>
#include <thread>

#include "apps/demo/demo_scene.h"
#include "apps/live/access.h"
#include "apps/live/server.h"
#include "apps/live/session.h"
#ifdef MTFKIT_HAVE_SCENE
#include "apps/live/space/space.h"
#include "apps/scene/render/sensor_picture.h"
#endif
#include "apps/config_command.h"
#include "apps/options.h"
#include "apps/sensor/sensor_air.h"
#include "apps/simulate/frames/frame_names.h"
#include "apps/terminal/interrupt.h"
#include "apps/terminal/output.h"
#include "apps/text/json.h"
#include "mtf/error.h"
#include "mtf/io/config/config_reader.h"
#include "mtf/io/file_checks.h"
#include "mtf/units.h"
#include "mtf/work/heap.h"

namespace apps {
namespace {

using namespace live;

/// The memory of pictures comes and goes with every frame, and touching a page of it for the first time may take 15 us
/// on a virtual machine: 5 ms for a picture of 640 x 512. So what is free stays for the next picture.
constexpr mtf::HeapRules kKeepPictures{
    .returned_from = 32 << 20, .kept_at_end = 256 << 20, .one_for_all_threads = true};

/// What the session is being made of, in words for a page that waits for it.
class Waiting {
 public:
  void tell(const std::string& words) {
    const std::scoped_lock lock(mutex_);
    words_ = words;
  }
  Answer answer() {
    const std::scoped_lock lock(mutex_);
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now() - begin_);
    return json_answer({{"waiting", words_ + " " + std::to_string(seconds.count()) + " s so far."}});
  }

 private:
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::mutex mutex_;
  std::string words_ = "The scene is being made.";
};

/// The cooled camera of `mtf demo` and its scene, made in memory.
std::pair<Sensor, SceneSource> demo() {
  constexpr std::int64_t kSize = 1024;
  mtf::io::ConfigResult parsed = mtf::io::parse_config(std::string(demo_camera()), "camera.toml", sensor_schema());
  mtf::io::cfg::require_no_errors(parsed.diagnostics, "camera.toml");
  mtf::io::Scene scene;
  scene.names = {"Y"};
  scene.grid = {kSize, kSize, 3.75, 3.75};
  scene.quantity = mtf::io::Quantity::temperature;
  scene.planes.push_back(demo_temperatures(demo_landscape(kSize)));
  return {std::make_shared<const mtf::io::SensorConfig>(std::move(parsed.config)),
          SceneSource{.file = "thermal.exr", .image = std::move(scene)}};
}

/// Hands the address to the desktop's opener; nothing happens where there is none. The opener is no child of this
/// process, so nobody has to wait for it.
void open_browser(const std::string& address) {
  if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return;
  const pid_t child = ::fork();
  if (child == 0) {
    if (::fork() == 0) ::execlp("xdg-open", "xdg-open", address.c_str(), static_cast<char*>(nullptr));
    ::_exit(0);
  }
  if (child > 0) ::waitpid(child, nullptr, 0);
}

/// Throws RuntimeError where there is no such image, or no file of a sequence.
void require_scene(const std::string& file) {
  if (const auto names = FrameNames::parse(file))
    names->find(std::nullopt);
  else
    mtf::io::input_file_size(file);
}

/// The session of a 3-D scene.
std::shared_ptr<Session> space_session(const LiveOptions& options, const Global& global, SessionOptions session,
                                       const Sensor& sensor, const std::shared_ptr<Waiting>& waiting) {
#ifdef MTFKIT_HAVE_SCENE
  // A sensor that cannot see such a scene is refused before the heat balance, not after it.
  static_cast<void>(scene::picture_sensor(*sensor, scene::PictureQuantity::weighted));
  if (const std::string words = scene::memory_words(*sensor, 2.0, scene::kLiveBytes); !words.empty())
    note(global, "note: " + words);
  session.scene_name = options.first;
  session.sensor_name = options.second;
  return std::make_shared<Session>(sensor,
                                   open_space({.scene = options.first,
                                               .temperatures = options.temperatures,
                                               .time = options.time,
                                               .no_air = options.no_air,
                                               .device = session.device,
                                               .tell = [waiting](const std::string& words) { waiting->tell(words); }},
                                              global),
                                   std::move(session));
#else
  static_cast<void>(global), static_cast<void>(session), static_cast<void>(sensor), static_cast<void>(waiting);
  throw mtf::UsageError(options.second + ": this build has no 3-D scenes; name a sensor file and an image");
#endif
}

/// The session of an image; of the demo's without a sensor.
std::shared_ptr<Session> image_session(const LiveOptions& options, SessionOptions session, Sensor sensor) {
  SceneSource scene;
  if (options.first.empty()) {
    std::tie(sensor, scene) = demo();
    session.sensor_name = "mtf-demo/camera.toml";
    session.scene_name = "mtf-demo/thermal.exr";
    session.command_before = "[ -d mtf-demo ] || mtf demo && ";
  } else {
    session.sensor_name = options.first;
    session.scene_name = options.second;
    scene.file = options.second;
    scene.read = options.read;
  }
  return std::make_shared<Session>(std::move(sensor), std::move(scene), std::move(session));
}

}  // namespace

int run_live(const LiveOptions& options, const Global& global) {
  mtf::set_heap(kKeepPictures);
  if (options.first.empty() != options.second.empty())
    throw mtf::UsageError("name a sensor file and a scene, or neither for the demo");
  const bool space = options.second.ends_with(".toml");
  if (!space && (!options.temperatures.empty() || !options.time.empty() || options.no_air))
    throw mtf::UsageError("--temperatures, --time and --no-air are of a 3-D scene: mtf live scene.toml sensor.toml");
  SessionOptions session{.tolerance = options.tolerance,
                         .nan = options.nan,
                         .device = device_of(options.device, global),
                         .threads = global.threads};
  // A sensor file that is wrong is said before there is a page. Scene and first picture are made while that is loaded;
  // what is wrong with them ends the command, and is said here, not in a browser.
  Sensor sensor;
  if (const std::string& file = space ? options.second : options.first; !file.empty())
    sensor = std::make_shared<const mtf::io::SensorConfig>(read_sensor(file, global));
  if (!space && !options.second.empty()) require_scene(options.second);
  const auto waiting = std::make_shared<Waiting>();
  const std::optional<double> tolerance = session.tolerance;
  const std::shared_future<std::shared_ptr<Session>> coming =
      std::async(std::launch::async, [&]() -> std::shared_ptr<Session> {
        return space ? space_session(options, global, std::move(session), sensor, waiting)
                     : image_session(options, std::move(session), sensor);
      }).share();
  std::future<void> first = std::async(std::launch::async, [coming, tolerance] {
    Session& answers = *coming.get();
    Json wanted{{"number", answers.first_number()}};
    if (tolerance) wanted["tolerance"] = *tolerance;
    const Answer made = answers.answer("frame", json_document(wanted, -1));
    if (const std::string problem = error_of(made); !problem.empty()) throw mtf::UsageError(problem);
  });

  // Until the first picture is there an interrupt ends the process at once: nobody waits for what is being made.
  StopInGoodOrder interrupt(global.quiet ? "" : "mtf: the live view ends\n");
  const std::string token = new_token();
  Server server({.port = options.port, .token = token}, find_page_file,
                [coming, waiting](const std::string& place, const std::string& body) {
                  constexpr std::chrono::milliseconds kPatience{300};  // a page hears so often what it waits for
                  if (place == "start" && coming.wait_for(kPatience) != std::future_status::ready)
                    return waiting->answer();
                  return coming.get()->answer(place, body);
                });
  const std::string address = "http://127.0.0.1:" + std::to_string(server.port()) + "/#" + token;
  print(address + "\n");
  note(global, "the live view is open to this machine alone; Ctrl-C ends it" +
                   (options.stay ? "" : ", as do " + mtf::format_double(options.linger_s) + " s without a page"));
  if (!options.no_browser) open_browser(address);
  bool ready = false;
  while (!interrupt.asked() && (options.stay || !ready || server.seconds_alone() < options.linger_s)) {
    if (ready) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    } else if (first.wait_for(std::chrono::milliseconds(50)) == std::future_status::ready) {
      ready = true;
      first.get();
      interrupt.keep();
    }
  }
  server.stop();
  return 0;
}

}  // namespace apps
