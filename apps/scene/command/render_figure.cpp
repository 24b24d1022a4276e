// SPDX-License-Identifier: Apache-2.0
#include "apps/scene/command/render_figure.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <list>
#include <vector>

#include "apps/figures/picture.h"
#include "apps/simulate/simulate.h"
#include "apps/text/message_words.h"

namespace apps {
namespace {

constexpr double kBlack = 0.01, kWhite = 0.03;

/// A power of a thousand that brings values to 1 ... 1000, where they are far from it.
int thousands(double value) {
  if (!(value > 0.0) || (value > 1e-2 && value < 1e5)) return 0;
  return 3 * static_cast<int>(std::floor(std::log10(value) / 3.0));
}

/// "W.m^-2.sr^-1" as "W/m2/sr", which fits above a panel.
std::string short_unit(const std::string& unit) {
  std::string text;
  for (std::size_t from = 0; from < unit.size();) {
    const std::size_t to = std::min(unit.find('.', from), unit.size()), power = unit.substr(from, to - from).find("^-");
    const std::string factor = unit.substr(from, to - from);
    if (power == std::string::npos)
      text += (text.empty() ? "" : ".") + factor;
    else
      text += "/" + factor.substr(0, power) + (factor.substr(power + 2) == "1" ? "" : factor.substr(power + 2));
    from = to + 1;
  }
  return text;
}

/// The panel of an image that fills `width` pixels; `copies` holds its values. `caption`: name and size.
Panel panel_of(const std::array<std::string, 2>& caption, mtf::ImageView<const float> image, const std::string& unit,
               std::int64_t width, std::list<mtf::Image>& copies) {
  std::vector<float> sorted;
  for (std::int64_t y = 0; y < image.height; ++y) sorted.insert(sorted.end(), image.row(y), image.row(y) + image.width);
  std::sort(sorted.begin(), sorted.end());
  const auto at = [&](double share) {
    return static_cast<double>(sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))]);
  };
  const int power = thousands(at(0.5));
  const double scale = std::pow(10.0, -power), low = scale * at(kBlack), high = scale * at(1.0 - kWhite);
  mtf::Image& copy = copies.emplace_back(image.width, image.height);
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x)
      copy.at(x, y) = static_cast<float>(scale * static_cast<double>(image.at(x, y)));
  const std::string in = (power != 0 ? "1e" + std::to_string(power) + " " : std::string()) + short_unit(unit);
  return {.caption = caption[0] + " [" + in + "], " + caption[1],
          .image = copy.view(),
          .zoom = static_cast<int>(std::max<std::int64_t>(1, width / image.width)),
          .low = low,
          .high = high > low ? high : low + 1.0,
          .quantity = ""};
}

std::string size_of(mtf::ImageView<const float> image) {
  return std::to_string(image.width) + " x " + std::to_string(image.height);
}

}  // namespace

void draw_pictures(const std::string& path, std::span<const SensorPictureFile> pictures, int threads) {
  std::list<mtf::Image> copies;
  std::list<SimulateResult> results;
  std::vector<Panel> panels;
  for (const SensorPictureFile& picture : pictures) {
    const std::string name = one_line(picture.sensor.system.name);
    const std::int64_t width = std::max<std::int64_t>(picture.radiance.width, 1024);
    panels.push_back(panel_of({name + ", radiance", size_of(picture.radiance) + " samples"}, picture.radiance,
                              picture.unit, width, copies));
    const SimulateResult& result =
        results.emplace_back(simulate(picture.sensor, {.file = picture.file}, {.threads = threads}));
    const mtf::Image& image = result.images.front().planes.front();
    panels.push_back(panel_of({name + ", image of the sensor", size_of(image.view()) + " pixels"}, image.view(),
                              result.report.unit(), width, copies));
  }
  write_picture(path, panels, true, 2);
}

}  // namespace apps
