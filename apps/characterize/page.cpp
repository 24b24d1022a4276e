// SPDX-License-Identifier: Apache-2.0
#include "apps/characterize/page.h"

#include <algorithm>
#include <cmath>

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
      return "radiance (W m^-2 sr^-1)";
  }
  return "";
}

std::string charts(const std::string& id, const std::vector<Figure>& figures) {
  std::string text;
  for (std::size_t i = 0; i < figures.size(); ++i)
    text += html_chart(id + "-" + std::to_string(i + 1), svg_figure(figures[i]));
  return text;
}

std::string numbers(const Characterization& camera) {
  HtmlTable table("Numbers", {"Number", "Value", "Sd", "95 % interval", "Unit", "Verdict", "From"}, {1, 2, 3});
  for (const Finding& f : camera.findings) {
    if (f.verdict == Verdict::not_determined) continue;
    const auto digits = [&](double v) { return f.sd > 0.0 ? shown_with_error(v, f.sd) : significant(v, 3); };
    const bool limit = f.verdict == Verdict::upper_limit;
    table.add({"<code class=\"number\">" + html(f.name) + "</code>", exact(f.value, digits(f.value)),
               f.sd > 0.0 ? exact(f.sd, significant(f.sd, 2)) : html_value(""),
               exact(f.low95, digits(f.low95)) + " .. " + exact(f.high95, digits(f.high95)),
               "<span class=\"unit\">" + html(f.unit) + "</span>",
               html(verdict_name(f.verdict)) + (limit && !f.why.empty() ? ": " + html(f.why) : ""), html(f.from)});
  }
  return table.html();
}

std::string stacks_table(const Characterization& camera, const std::string& light) {
  HtmlTable table("Stacks",
                  {"Stack", html(light), "Exposure (s)", "Frames", "Mean (counts)", "Temporal noise (counts)", "Used"},
                  {1, 2, 3, 4, 5});
  for (std::size_t i = 0; i < camera.stacks.size(); ++i) {
    const Stack& s = camera.stacks[i];
    table.add({html(s.name), html_value(s.light), s.time_s > 0.0 ? html_value(s.time_s) : html_value(""),
               std::to_string(s.sums.frames), html_value(s.sums.mean),
               html_value(std::sqrt(s.sums.squares.value[radiometry::kTvh])),
               camera.level_of[i] >= 0 ? "yes"
               : s.saturates           ? "no: the pixels are full"
               : s.is_clipped_high()   ? "no: at the upper end"
                                       : "no: at the lower end"});
  }
  return table.html();
}

std::string summary(const Characterization& camera, const PageWords& words, const std::string& light) {
  const radiometry::MeanSquares& size = camera.stacks.front().sums.squares;
  const auto& t = camera.transfer;
  return html_section(
      "summary", "What was measured",
      html(words.camera) + ": " + significant(size.columns, 9) + " &times; " + significant(size.rows, 9) + " pixels, " +
          std::to_string(words.bits) + " bits, " + plural(std::ssize(camera.stacks), "stack") + " of flat frames.",
      (camera.misfit
           ? "<p class=\"warning\">The model does not describe the frames: " + html(camera.misfit_reason) + ".</p>\n"
           : "") +
          numbers(camera) + "<p>Photon transfer: chi-square " + significant(t.chi2, 4) + " with " +
          std::to_string(t.dof) + " degrees of freedom, p = " + significant(t.p, 2) + ".</p>\n<h3>Stacks</h3>\n" +
          stacks_table(camera, light) + (words.edges.empty() ? "" : "<p>" + html(words.edges) + "</p>\n"));
}

std::string notes(const Characterization& camera, const PageWords& words) {
  HtmlTable table("Not determined", {"Number", "Why"});
  for (const Finding& f : camera.findings)
    if (f.verdict == Verdict::not_determined)
      table.add({"<code class=\"number\">" + html(f.name) + "</code>", html(f.why)});
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

}  // namespace

std::string characterize_page(const Characterization& camera, const std::vector<PatternPlane>& planes,
                              const StacksFile& stacks, const PageWords& words) {
  const std::string light = light_label(stacks.unit);
  const bool photons = stacks.tells_photons();
  const std::string gap = planes.empty() ? "<p class=\"gap\">There is no dark stack that is not clipped.</p>\n" : "";
  std::string profiles = gap, bars, defects = gap;
  for (const auto& [place, name] : {std::pair{camera.dark, "dark"}, std::pair{camera.bright, "bright"}})
    if (place >= 0)
      profiles += charts(std::string("profile-") + name, profile_figures(camera.stacks[static_cast<std::size_t>(place)],
                                                                         std::string(name) + " mean frame"));
  const auto is_used = [](int level) { return level >= 0; };
  const auto first = std::ranges::find_if(camera.level_of, is_used) - camera.level_of.begin();
  const auto last =
      camera.level_of.rend() - std::find_if(camera.level_of.rbegin(), camera.level_of.rend(), is_used) - 1;
  for (const auto place : {first, last})
    bars += html_chart(
        "components-" + std::to_string(place),
        component_bars(camera.stacks[static_cast<std::size_t>(place)], camera.find("electrons_per_count")->value));
  for (const PatternPlane& p : planes)
    defects +=
        "<p>" + plural(std::ssize(p.squares.defects), "pixel") + " of the " + p.name +
        " beyond 4.5 robust standard deviations" +
        (p.squares.defects.size() > kDefectsDrawn ? "; the largest " + std::to_string(kDefectsDrawn) + " are drawn"
                                                  : "") +
        ".</p>\n";
  if (std::ranges::any_of(planes, [](const PatternPlane& p) { return !p.squares.defects.empty(); }))
    defects += charts("defect", {defect_figure(planes)});
  const std::vector<HtmlPart> parts{
      {"summary", "Numbers", summary(camera, words, light)},
      {"transfer", "Photon transfer",
       html_section("transfer", "Photon transfer",
                    "The slope is the gain, the start the read noise; means and variances are fitted together.",
                    charts("transfer", transfer_figures(camera)))},
      {"response", "Response",
       html_section(
           "response", "Response and linearity",
           "The line is that of relative least squares through the dark, over signals from 5 % of the largest on. "
           "Errors within the band of the noise say nothing of the camera.",
           charts("response", response_figures(camera, light)))},
      {"snr", "SNR",
       html_section("snr", "Signal to noise",
                    camera.crosstalk.found
                        ? "Crosstalk smooths the noise of neighbours, so a pixel may lie above its own shot noise."
                        : "",
                    charts("snr", {snr_figure(camera, light, photons)}))},
      {"spectra", "Spectrograms",
       html_section(
           "spectra", "Spectrograms",
           "A pattern without order has the same power at every frequency. Defects are left out.",
           gap + of_planes("spectra", planes, [](const PatternPlane& p) { return std::vector{spectrum_figure(p)}; }))},
      {"profiles", "Profiles",
       html_section("profiles", "Profiles",
                    "Shaded: from the least to the most of a column or row. Pixels far beyond the others lie outside.",
                    profiles)},
      {"histograms", "Histograms",
       html_section(
           "histograms", "Histograms",
           "Deviations of pixels from their row and column, with the normal curve of the variance that was found. "
           "What is beyond 10 standard deviations is in the accumulated histograms alone.",
           gap + of_planes("histograms", planes, histogram_figures))},
      {"components", "3-D noise",
       html_section("components", "Three-dimensional noise",
                    "Fixed pixels (vh) include the defects, which DSNU and PRNU leave out.", bars)},
      {"defects", "Defects", html_section("defects", "Map of defects", "All of them: defects.csv.", defects)},
      {"notes", "Not determined", notes(camera, words)},
      {"provenance", "Provenance",
       html_section(
           "provenance", "Provenance", "",
           "<p>mtf " + html(mtf::version) + " " + html(mtf::git_commit) + "</p>\n<p><code>" + html(words.command) +
               "</code></p>\n<p>" + html(stacks.file) + ", sha256 <span class=\"hash\">" + html(stacks.sha256) +
               "</span></p>\n" +
               (stacks.nominal_sha256.empty() ? ""
                                              : "<p>" + html(stacks.nominal) + ", sha256 <span class=\"hash\">" +
                                                    html(stacks.nominal_sha256) + "</span></p>\n"))}};
  return html_page(html(words.camera), "camera from its own frames, by mtf " + html(mtf::version), parts);
}

}  // namespace apps
