// SPDX-License-Identifier: Apache-2.0
#pragma once

// The text files of apps/report and of its npm packages, built into the command.

#include <string_view>

namespace apps {

struct ReportFiles {
  std::string_view page;     ///< HTML with {{names}} of what is put in
  std::string_view style;    ///< CSS
  std::string_view script;   ///< ours
  std::string_view library;  ///< Vega, Vega-Lite and Vega-Embed; empty in a build without node, npm or network
  std::string_view notices;  ///< their licences
};

const ReportFiles& report_files();

}  // namespace apps
