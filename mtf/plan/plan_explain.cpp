// SPDX-License-Identifier: Apache-2.0

#include "mtf/plan/plan_impl.h"
#include "mtf/words.h"

namespace mtf {
namespace {

std::string short_number(double value) { return significant(value, 2); }

std::string size_text(std::int64_t width, std::int64_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

}  // namespace

std::string Plan::explain() const {
  const PlanReport& r = impl_->report;
  std::string text = "plan      " + r.method + ", " + size_text(r.in.width, r.in.height) + " samples of " +
                     format_double(r.in.step_x_um) + " x " + format_double(r.in.step_y_um) + " um -> " +
                     size_text(r.out.width, r.out.height) + " pixels of " + format_double(r.out.step_x_um) + " x " +
                     format_double(r.out.step_y_um) + " um\n";
  if (r.out.width < r.whole_pitches_x || r.out.height < r.whole_pitches_y)
    text += "format    the scene holds " + size_text(r.whole_pitches_x, r.whole_pitches_y) + " whole pixels\n";
  if (r.method.starts_with("fft")) {
    text += "axes      x: " + r.axes[0] + "; y: " + r.axes[1] + "\n";
    text += "kept      " + size_text(r.kept[0], r.kept[1]) + " of " + size_text(r.available[0], r.available[1]) +
            " frequencies\n";
  }
  for (const std::string& line : r.merged) text += "merged    " + line + "\n";
  if (r.wavelengths > 1) text += "band      " + std::to_string(r.wavelengths) + " wavelengths\n";
  for (const Omission& o : r.omitted)
    text += "left out  " + o.what + " (error at most " + short_number(o.bound) + ", saves about " +
            short_number(o.saved_ms) + " ms)\n";
  for (const std::string& note : r.notes) text += "note      " + note + "\n";
  for (const Candidate& c : r.candidates) {
    text += (c.reason.empty() ? "chosen    " : "other     ") +
            std::string(kMethodNames[static_cast<std::size_t>(c.method)]);
    if (!c.detail.empty()) text += ": " + c.detail;
    if (c.cost_ms > 0.0)
      text += "; predicted error " + short_number(c.predicted.total()) + ", " + short_number(c.cost_ms) +
              (c.measured ? " ms measured" : " ms");
    text += (c.reason.empty() ? "" : "; " + c.reason) + "\n";
  }
  if (impl_->options.spectrum) text += "for       this very scene: errors are weighed by its spectrum\n";
  const PredictedError& e = r.predicted;
  text += "error     predicted <= " + short_number(e.total()) + " of the scene's std, tolerance " +
          short_number(r.tolerance) + " (dropped " + short_number(e.dropped) + ", table " + short_number(e.table) +
          ", band " + short_number(e.band) + ", cut " + short_number(e.cut) + ", wrap " + short_number(e.wrap) +
          ", kernel " + short_number(e.kernel) + ", flat lines " + short_number(e.flat) + ", float32 " +
          short_number(e.arithmetic) + ")\n";
  const double mib = 1.0 / (1024.0 * 1024.0);
  text += "memory    OTF " + short_number(static_cast<double>(r.otf_bytes) * mib) + " MiB, buffers " +
          short_number(static_cast<double>(r.run_bytes) * mib) + " MiB\n";
  return text;
}

}  // namespace mtf
