// SPDX-License-Identifier: Apache-2.0
#include "apps/characterize/page.h"

#include <algorithm>
#include <cmath>

#include "apps/characterize/number_words.h"
#include "apps/characterize/page_figures.h"
#include "apps/edges/fit_parameters.h"
#include "apps/page/html.h"
#include "apps/text/message_words.h"
#include "mtf/units.h"
#include "mtf/version.h"

namespace apps {
namespace {

using calib::Characterization, calib::Finding, calib::Stack, calib::Verdict;

/// As it is read, with all digits for programs.
std::string exact(double value, const std::string& text) {
  const std::string digits = mtf::format_double(value);
  return "<data value=\"" + digits + "\" title=\"" + digits + "\">" + html(text) + "</data>";
}

std::string light_label(LightUnit unit) {
  switch (unit) {
    case LightUnit::photons:
    case LightUnit::irradiance:
      return "light (photons at a pixel)";
    case LightUnit::relative:
      return "light (relative)";
    case LightUnit::exposure:
      return "light (exposure in s)";
    case LightUnit::temperature:
    case LightUnit::radiance:
      return "radiance, weighted by the response (W m^-2 sr^-1)";
  }
  return "";
}

std::string charts(const std::string& id, const std::vector<Figure>& figures) {
  std::string text;
  for (std::size_t i = 0; i < figures.size(); ++i)
    text += html_chart(id + "-" + std::to_string(i + 1), svg_figure(figures[i]));
  return text;
}

/// Value and standard deviation with the unit, and what the number is below its name.
std::string numbers(const Characterization& camera) {
  HtmlTable table("Numbers", {"Number", "Value &plusmn; standard deviation", "95 % interval"}, {1, 2});
  const auto small = [](const std::string& text) { return "<br><span class=\"why\">" + text + "</span>"; };
  for (const Finding& f : camera.findings) {
    if (f.verdict == Verdict::not_determined) continue;
    const bool limit = f.verdict == Verdict::upper_limit;
    const auto digits = [&](double v) { return f.sd > 0.0 && !limit ? shown_with_error(v, f.sd) : significant(v, 3); };
    const auto spread = [&](double sd) { return " &plusmn; " + exact(sd, significant(sd, 2)); };
    const double systematic = f.sd_systematic.value_or(0.0);
    table.add({"<code class=\"number\">" + html(f.name) + "</code>" +
                   small(html(std::string(number_words(f.name)) + " From: " + f.from)),
               exact(f.value, digits(f.value)) + (f.sd > 0.0 ? spread(f.sd) : "") + " <span class=\"unit\">" +
                   html(f.unit) + "</span>" + (systematic > 0.0 ? "<br>" + spread(systematic) + " (blackbodies)" : "") +
                   (f.verdict == Verdict::determined
                        ? ""
                        : small(html(verdict_name(f.verdict)) + (limit && !f.why.empty() ? ": " + html(f.why) : ""))),
               f.verdict == Verdict::predicted
                   ? html_value("")
                   : exact(f.low95, digits(f.low95)) + " .. " + exact(f.high95, digits(f.high95))});
  }
  return table.html();
}

std::string stacks_table(const Characterization& camera, const std::string& light, const StacksFile& file) {
  const bool kelvin = file.unit == LightUnit::temperature;
  HtmlTable table("Stacks",
                  {"Stack", html(light), kelvin ? "Temperature (K)" : "Exposure (s)", "Frames", "Mean (counts)",
                   "Temporal noise (counts)", "Used"},
                  {1, 2, 3, 4, 5});
  for (std::size_t i = 0; i < camera.stacks.size(); ++i) {
    const Stack& s = camera.stacks[i];
    const auto entry = std::ranges::find(file.stacks, s.name, &StackEntry::name);
    table.add({html(s.name), html_value(s.light),
               kelvin && entry != file.stacks.end() ? html_value(entry->light)
               : s.time_s > 0.0                     ? html_value(s.time_s)
                                                    : html_value(""),
               std::to_string(s.sums.frames), html_value(s.sums.mean),
               html_value(std::sqrt(s.sums.squares.value[radiometry::kTvh])),
               camera.level_of[i] >= 0 ? "yes"
               : s.saturates           ? "no: the pixels are full"
               : s.is_clipped_high()   ? "no: at the upper end"
                                       : "no: at the lower end"});
  }
  return table.html();
}

std::string summary(const Characterization& camera, const StacksFile& file, const PageWords& words,
                    const std::string& light) {
  const radiometry::MeanSquares& size = camera.stacks.front().sums.squares;
  const auto& t = camera.transfer;
  return html_section(
      "summary", "What was measured",
      html(words.camera) + ": " + significant(size.columns, 9) + " &times; " + significant(size.rows, 9) + " pixels, " +
          std::to_string(words.bits) + " bits, " + plural(std::ssize(camera.stacks), "stack") + " of flat frames.",
      (camera.misfit
           ? "<p class=\"warning\">The model does not describe the frames: " + html(camera.misfit_reason) + ".</p>\n"
           : "") +
          numbers(camera) +
          "<p>The interval holds the truth in 95 of 100 cases, about; an upper limit is of what these frames do not "
          "show to be there.</p>\n<p>" +
          (file.has_blackbodies() ? "Line of counts over radiance" : "Photon transfer") + ": chi-square " +
          significant(t.chi2, 4) + " with " + plural(t.dof, "degree") + " of freedom, p = " + significant(t.p, 2) +
          ", the probability that noise alone makes it as large.</p>\n<h3>Stacks</h3>\n" +
          stacks_table(camera, light, file) + (words.edges.empty() ? "" : "<p>" + html(words.edges) + "</p>\n"));
}

std::string notes(const Characterization& camera, const PageWords& words) {
  HtmlTable table("Not determined", {"Number", "Why"});
  for (const Finding& f : camera.findings)
    if (f.verdict == Verdict::not_determined)
      table.add({"<code class=\"number\">" + html(f.name) + "</code><br><span class=\"why\">" +
                     html(number_words(f.name)) + "</span>",
                 html(f.why)});
  std::string text = table.html() +
                     "<p>Keys of the sensor file without a measured number: " + html(joined(words.left, "; ")) +
                     ".</p>\n<h3>Warnings</h3>\n";
  for (const std::string& warning : camera.warnings) text += "<p class=\"warning\">" + html(warning) + "</p>\n";
  return html_section("notes", "Not determined, and warnings", "",
                      camera.warnings.empty() ? text + "<p>None.</p>\n" : text);
}

/// Figures of each plane.
template <class Draw>
std::string of_planes(const std::string& id, const std::vector<PatternPlane>& planes, const Draw& draw) {
  std::vector<Figure> figures;
  for (const PatternPlane& p : planes)
    for (Figure& figure : draw(p)) figures.push_back(std::move(figure));
  return charts(id, figures);
}

/// What blackbodies show, then what light in other units does.
std::vector<HtmlPart> response_parts(const Characterization& camera, const StacksFile& stacks, const PageWords& words,
                                     const std::string& light) {
  if (stacks.has_blackbodies())
    return {{"response", "SiTF",
             html_section("response", "Signal transfer",
                          "The slope, times the change of the radiance with a kelvin, is SiTF. The band of the "
                          "residuals has the errors of the temperatures.",
                          charts("response", sitf_figures(camera, light)))},
            {"predicted", "MRTD, MDTD",
             words.predicted.empty()
                 ? ""
                 : html_section("predicted", "Predicted MRTD and MDTD",
                                "Of the budget of sensor.toml, the twin: no observer looked at the camera.",
                                charts("predicted", words.predicted))}};
  return {{"transfer", "Photon transfer",
           html_section("transfer", "Photon transfer",
                        "The slope is the gain, the start the read noise; means and variances are fitted together.",
                        charts("transfer", transfer_figures(camera)))},
          {"response", "Response",
           html_section("response", "Response and linearity",
                        "The line is that of relative least squares through the dark, over signals from 5 % of the "
                        "largest on. Errors within the band of the noise say nothing of the camera.",
                        charts("response", response_figures(camera, light)))},
          {"snr", "SNR",
           html_section("snr", "Signal to noise",
                        "Of one frame; fixed patterns count where frames are not corrected." +
                            std::string(camera.crosstalk.found ? " Crosstalk smooths the noise of neighbours, so a "
                                                                 "pixel may lie above its own shot noise."
                                                               : ""),
                        charts("snr", {snr_figure(camera, light, stacks.tells_photons())}))}};
}

std::string defects_of(const std::vector<PatternPlane>& planes) {
  std::string text;
  for (const PatternPlane& p : planes)
    text += "<p>" + plural(std::ssize(p.squares.defects), "pixel") + " of the " + p.name +
            " beyond 4.5 robust standard deviations" +
            (p.squares.defects.size() > kDefectsDrawn ? "; the largest " + std::to_string(kDefectsDrawn) + " are drawn"
                                                      : "") +
            ".</p>\n";
  if (std::ranges::any_of(planes, [](const PatternPlane& p) { return !p.squares.defects.empty(); }))
    text += charts("defect", {defect_figure(planes)});
  return text;
}

}  // namespace

std::string characterize_page(const Characterization& camera, const std::vector<PatternPlane>& planes,
                              const StacksFile& stacks, const PageWords& words) {
  const bool kelvin = stacks.has_blackbodies();
  const std::string light = light_label(stacks.unit);
  const std::string gap = planes.empty() ? "<p class=\"gap\">There is no dark stack that is not clipped.</p>\n" : "";
  const NoiseUnit unit = noise_unit(camera);
  const FitEnds ends = fit_ends(camera);
  const auto stack_at = [&](int place) { return &camera.stacks[static_cast<std::size_t>(place)]; };
  std::vector<std::pair<const Stack*, std::string>> profiled;
  if (camera.dark >= 0) profiled.emplace_back(stack_at(camera.dark), kelvin ? "mean frame" : "dark mean frame");
  if (camera.bright >= 0) profiled.emplace_back(stack_at(camera.bright), "bright mean frame");
  const std::vector<const Stack*> shown =
      kelvin ? std::vector<const Stack*>{stack_at(camera.dark)} : std::vector<const Stack*>{&ends.least, &ends.most};
  std::string profiles = gap, bars, in_time;
  for (const auto& [stack, name] : profiled)
    profiles += charts("profile-" + std::to_string(stack - camera.stacks.data()), profile_figures(*stack, name));
  for (const Stack* const stack : shown) {
    const std::string place = std::to_string(stack - camera.stacks.data());
    bars += html_chart("components-" + place, component_bars(camera, *stack));
    in_time += charts("time-" + place, time_figures(*stack, unit));
  }
  std::vector<HtmlPart> parts{{"summary", "Numbers", summary(camera, stacks, words, light)}};
  for (HtmlPart& part : response_parts(camera, stacks, words, light)) parts.push_back(std::move(part));
  for (HtmlPart& part : std::vector<HtmlPart>{
           {"spectra", "Spectrograms",
            html_section("spectra", "Spectrograms",
                         "A pattern without order has the same power at every frequency. Defects are left out.",
                         gap + of_planes("spectra", planes,
                                         [](const PatternPlane& p) { return std::vector{spectrum_figure(p)}; }))},
           {"time", "Noise in time",
            html_section(
                "time", "Noise in time",
                "White noise has the same power at every frequency; 1/f noise and drifts rise towards the left, a lamp "
                "that flickers is a peak. The means of frames lie above their band where all pixels share noise. " +
                    std::string(kelvin ? "The noise of a pixel is its NETD. " : "") +
                    "Pixels right of the curve are noisier than the others.",
                in_time)},
           {"profiles", "Profiles",
            html_section("profiles", "Profiles",
                         "Shaded: from the least to the most of a column or row. Pixels far beyond the others lie "
                         "outside.",
                         profiles)},
           {"histograms", "Histograms",
            html_section("histograms", "Histograms",
                         "Deviations of pixels from their row and column, with the normal curve of the variance that "
                         "was found. What is beyond 10 standard deviations is in the accumulated histograms alone.",
                         gap + of_planes("histograms", planes, histogram_figures))},
           {"components", "3-D noise",
            html_section("components", "Three-dimensional noise",
                         "What pixels, rows, columns and whole frames have each for themselves, from frame to frame "
                         "and fixed. Fixed pixels (vh) include the defects, which DSNU and PRNU leave out.",
                         bars)},
           {"defects", "Defects",
            html_section("defects", "Map of defects", "All of them: defects.csv.", gap + defects_of(planes))},
           {"notes", "Not determined", notes(camera, words)},
           {"provenance", "Provenance",
            html_section(
                "provenance", "Provenance", "",
                "<p>mtf " + html(mtf::version) + " " + html(mtf::git_commit) + "</p>\n<p><code>" + html(words.command) +
                    "</code></p>\n<p>" + html(stacks.file) + ", sha256 <span class=\"hash\">" + html(stacks.sha256) +
                    "</span></p>\n" +
                    (stacks.nominal_sha256.empty() ? ""
                                                   : "<p>" + html(stacks.nominal) + ", sha256 <span class=\"hash\">" +
                                                         html(stacks.nominal_sha256) + "</span></p>\n"))}})
    parts.push_back(std::move(part));
  return html_page(html(words.camera), "camera from its own frames, by mtf " + html(mtf::version), parts);
}

}  // namespace apps
