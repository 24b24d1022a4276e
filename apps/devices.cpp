// SPDX-License-Identifier: Apache-2.0

// `mtf devices`: what there is, whether it is admitted, how fast it is.

#include <optional>
#include <string>
#include <vector>

#include "apps/options.h"
#include "apps/terminal/output.h"
#include "apps/terminal/text_table.h"
#include "apps/text/json.h"
#include "mtf/device/device.h"

namespace apps {
namespace {

struct TestedDevice {
  mtf::DeviceInfo info;
  std::optional<mtf::DeviceTest> test;  ///< of one that is admitted
  std::string reason;                   ///< why it is not
};

TestedDevice tested(const mtf::DeviceInfo& info) {
  try {
    return {info, mtf::open_device(info)->test(), ""};
  } catch (const mtf::RuntimeError& error) {
    return {info, std::nullopt, one_line(error.what())};
  }
}

std::vector<TestedDevice> all_tested(const mtf::DeviceList& found) {
  std::vector<TestedDevice> list;
  for (const mtf::DeviceInfo& info : found.devices) list.push_back(tested(info));
  return list;
}

/// Gigabytes a second of a transfer that takes so many nanoseconds a byte.
std::string speed_text(double ns) { return ns > 0.0 ? fixed(1.0 / ns, 1) : ""; }

std::string devices_table(const std::vector<TestedDevice>& list, const std::vector<std::string>& notes) {
  TextTable table({"device", "name", "GiB", "driver", "admitted", "rms error", "filter ms", "GB/s up", "down"});
  std::string refused;
  for (const auto& [info, test, reason] : list) {
    table.add({info.id, one_line(info.name), fixed(static_cast<double>(info.bytes) / 1073741824.0, 1),
               one_line(info.driver), test ? "yes" : "no",
               test ? significant(std::max(test->rms[0], test->rms[1]), 2) : "",
               test ? fixed(test->filter_ms[1], 3) : "", test ? speed_text(test->upload_ns) : "",
               test ? speed_text(test->download_ns) : ""});
    if (!test) refused += reason + "\n";
  }
  constexpr Align l = Align::left, r = Align::right;
  std::string text = list.empty() ? "no devices beside the processor\n" : table.aligned({l, l, r, l, l, r, r, r, r});
  text += refused;
  for (const std::string& note : notes) text += one_line(note) + "\n";
  return text;
}

std::string devices_json(const std::vector<TestedDevice>& list, const std::vector<std::string>& notes) {
  Json json;
  json["devices"] = Json::array();
  for (const auto& [info, test, reason] : list) {
    Json one = {{"id", info.id},         {"name", info.name},           {"vendor", info.vendor},
                {"driver", info.driver}, {"backend", info.backend},     {"memory_bytes", info.bytes},
                {"cpu", info.cpu},       {"admitted", test.has_value()}};
    if (test) {
      one["rms_error"] = std::vector<double>(test->rms.begin(), test->rms.end());
      one["filter_ms"] = test->filter_ms[1];
      one["upload_ns_per_byte"] = test->upload_ns;
      one["download_ns_per_byte"] = test->download_ns;
      one["transfer_ms"] = test->transfer_ms;
    } else {
      one["reason"] = reason;
    }
    json["devices"].push_back(one);
  }
  json["notes"] = notes;
  return json_document(json);
}

}  // namespace

mtf::DeviceChoice device_of(const std::string& word, const Global& global) {
  std::string told;
  mtf::DeviceChoice choice = mtf::choose_device(word, told);
  if (!told.empty()) note(global, "note: " + one_line(told));
  return choice;
}

std::string devices_report() {
  const mtf::DeviceList found = mtf::devices();
  return devices_json(all_tested(found), found.notes);
}

int run_devices(const DevicesOptions& options, const Global&) {
  if (options.format == Format::json) {
    print(devices_report());
    return 0;
  }
  const mtf::DeviceList found = mtf::devices();
  print(devices_table(all_tested(found), found.notes));
  return 0;
}

}  // namespace apps
