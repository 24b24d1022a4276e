// SPDX-License-Identifier: Apache-2.0

// What `mtf live` takes.

#include "apps/command_line.h"
#include "apps/commands.h"
#include "apps/modules/modules.h"

namespace apps {

Command live_command() {
  Command app{
      "live", "the live view: a scene through a sensor in the browser, with a slider for every parameter",
      "Prints the address of a page and opens it. Of a sensor file and an image, as mtf simulate; of a scene file\n"
      "and a sensor file, as mtf fly: the camera goes where the mouse takes it. Without files: the camera and scene\n"
      "of mtf demo; a 3-D scene is made by mtf scene demo. The page\n"
      "answers to this machine alone; from another one use a tunnel: ssh -L 8080:127.0.0.1:8080 host, there\n"
      "mtf live --port 8080 --no-browser, and the printed address here. It changes no file: the page hands the\n"
      "changed sensor file, the picture and the command line to the browser's downloads and clipboard.",
      "  mtf live\n"
      "  mtf live sensor.toml scene.exr --tolerance 1e-3"};
  auto& options = options_of<LiveOptions>(
      app, [](const auto& given, const Global& global) { return live_module().live(given, global); });
  add_file(app, "first", "sensor file; of a 3-D scene its scene file (TOML)", options.first).required = false;
  add_file(app, "second", "image of the scene, or frame.%04d.exr for a sequence; of a 3-D scene the sensor file",
           options.second)
      .required = false;
  add_channel_choice(app, options.read);
  add_value(app, "--tolerance", "X", "rms error allowed, at the start; default: that of mtf simulate",
            options.tolerance, fraction());
  add_choice(app, "--nan", "POLICY", "NaN and infinite pixels: refuse (default), fill or propagate", kNanPolicies,
             options.nan);
  add_text(app, "--temperatures", "PATH",
           "of a 3-D scene: folder that mtf heat wrote, or a table of facets; else the heat balance is worked out",
           options.temperatures);
  add_text(app, "--time", "INSTANT", "of the first picture of a 3-D scene, UTC; default: where temperatures begin",
           options.time);
  add_flag(app, "--no-air", "of a 3-D scene surfaces alone, for sensors that bring a path of their own",
           options.no_air);
  add_value(app, "--port", "N", "port on 127.0.0.1; default: one that is free", options.port, whole(1, 65535));
  add_flag(app, "--no-browser", "print the address only", options.no_browser);
  add_flag(app, "--stay", "go on when no page is open; else it ends a minute after the last one", options.stay);
  add_value(app, "--linger", "S", "seconds without a page until it ends; default 60", options.linger_s,
            within(1.0, 1e6, " is outside 1 to 1e6"));
  return app;
}

}  // namespace apps
