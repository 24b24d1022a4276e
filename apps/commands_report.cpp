// SPDX-License-Identifier: Apache-2.0

// What `mtf report` takes.

#include <memory>

#include "apps/command_line.h"
#include "apps/commands.h"

namespace apps {

Command report_command() {
  const auto shared = std::make_shared<ReportOptions>();
  ReportOptions& options = *shared;
  Command app{"report", "one page of HTML from the folder of a sweep",
              "Summary, charts to interact with, the chosen designs side by side with their curves, images and noise,\n"
              "sensitivities, error against time. The file needs nothing else: no network, no other files.",
              "  mtf report sweep\n"
              "  mtf report sweep -o study.html"};
  add_file(app, "folder", "that `mtf sweep STUDY -o DIR` wrote", options.folder);
  add_text(app, "--scene", "FILE", "scene for images of the chosen designs; default: a computed one", options.scene);
  add_text(app, "-o,--out", "FILE", "write the page here; default: report.html in the folder", options.out);
  app.run = [shared](const Global& global) { return run_report(*shared, global); };
  return app;
}

}  // namespace apps
