// SPDX-License-Identifier: Apache-2.0
#include "apps/figures/picture.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "apps/text/message_words.h"
#include "mtf/error.h"
#include "mtf/io/image_io.h"

namespace apps {
namespace {

// Pixels of the picture. Text is large, since pages show pictures of this width at half their size.
constexpr std::int64_t kMargin = 16, kHead = 52, kBarGap = 14, kBar = 24, kFoot = 46;
constexpr double kTextSize = 2.2, kTextGap = 16.0;
constexpr float kGround = 0.1F;  // grey value behind the panels
constexpr mtf::io::Colour kText{235, 235, 235}, kFrame{140, 140, 140};

std::int64_t shown_width(const Panel& panel) { return panel.image.width * panel.zoom; }
std::int64_t shown_height(const Panel& panel) { return panel.image.height * panel.zoom; }

/// A value as share of the panel's range.
float share(const Panel& panel, float value) {
  return static_cast<float>((static_cast<double>(value) - panel.low) /
                            (panel.high > panel.low ? panel.high - panel.low : 1.0));
}

std::string end_words(double value, const char* beyond, std::int64_t clipped, std::int64_t pixels) {
  std::string text = significant(value, 4);
  if (clipped > 0)
    text += std::string(" and ") + beyond + ": " +
            significant(100.0 * static_cast<double>(clipped) / static_cast<double>(pixels), 2) + " %";
  return text;
}

mtf::io::Stroke frame(std::int64_t x, std::int64_t y, std::int64_t width, std::int64_t height) {
  const double left = static_cast<double>(x), top = static_cast<double>(y);
  const double right = left + static_cast<double>(width), bottom = top + static_cast<double>(height);
  return {{{left, top}, {right, top}, {right, bottom}, {left, bottom}, {left, top}}, kFrame};
}

/// Draws a panel whose image has its upper left corner at (x, y), and its bar with the upper edge at `bar_y`.
void place(const Panel& panel, std::int64_t x, std::int64_t y, std::int64_t bar_y, mtf::Image& page,
           mtf::io::Drawing& drawing) {
  const std::int64_t width = shown_width(panel);
  for (std::int64_t j = 0; j < shown_height(panel); ++j)
    for (std::int64_t i = 0; i < width; ++i)
      page.at(x + i, y + j) = share(panel, panel.image.at(i / panel.zoom, j / panel.zoom));
  for (std::int64_t j = 0; j < kBar; ++j)
    for (std::int64_t i = 0; i < width; ++i)
      page.at(x + i, bar_y + j) = static_cast<float>(i) / static_cast<float>(std::max<std::int64_t>(1, width - 1));
  drawing.strokes.push_back(frame(x, bar_y, width, kBar));

  const BarEnds ends = bar_ends(panel);
  const double left = static_cast<double>(x), right = static_cast<double>(x + width), middle = 0.5 * (left + right);
  const double text_y = static_cast<double>(bar_y + kBar) + 1.9 * kTextGap;
  const auto add = [&](double at, double base, const std::string& text, double alignment) {
    drawing.captions.push_back({at, base, text, kText, kTextSize, alignment});
  };
  add(left, static_cast<double>(y) - kTextGap, panel.caption, 0.0);
  add(left, text_y, ends.low, 0.0);
  add(middle, text_y, panel.quantity, 0.5);
  add(right, text_y, ends.high, 1.0);
}

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

}  // namespace

void require_picture_name(const std::string& file) {
  if (!file.empty() && !file.ends_with(".png"))
    throw mtf::UsageError("--picture: " + one_line(file) + ": is a PNG; give it the ending .png");
}

void PairedPicture::add(const Caption& caption, mtf::ImageView<const float> image, const std::string& unit,
                        std::int64_t width) {
  std::vector<float> sorted;
  for (std::int64_t y = 0; y < image.height; ++y)
    std::copy_if(image.row(y), image.row(y) + image.width, std::back_inserter(sorted),
                 [](float value) { return std::isfinite(value); });
  std::sort(sorted.begin(), sorted.end());
  if (sorted.empty()) sorted.push_back(0.0F);
  const auto at = [&](double share) {
    return static_cast<double>(sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))]);
  };
  const int power = thousands(at(0.5));
  const double scale = std::pow(10.0, -power), low = scale * at(kBlack), high = scale * at(1.0 - kWhite);
  mtf::Image& copy = images_.emplace_back(image.width, image.height);
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x) {
      const double value = scale * static_cast<double>(image.at(x, y));
      copy.at(x, y) = static_cast<float>(std::isfinite(value) ? value : low);
    }
  const std::string in = (power != 0 ? "1e" + std::to_string(power) + " " : std::string()) + short_unit(unit);
  panels_.push_back({.caption = caption.name + (in.empty() ? "" : " [" + in + "]") + ", " +
                                std::to_string(image.width) + " x " + std::to_string(image.height) + " " +
                                caption.pixels,
                     .image = copy.view(),
                     .zoom = static_cast<int>(std::max<std::int64_t>(1, width / image.width)),
                     .low = low,
                     .high = high > low ? high : low + 1.0});
}

void PairedPicture::write(const std::string& path) const { write_picture(path, panels_, true, 2); }

BarEnds bar_ends(const Panel& panel) {
  std::int64_t below = 0, above = 0;
  for (std::int64_t y = 0; y < panel.image.height; ++y)
    for (const float value : std::span(panel.image.row(y), static_cast<std::size_t>(panel.image.width))) {
      below += static_cast<double>(value) < panel.low ? 1 : 0;
      above += static_cast<double>(value) > panel.high ? 1 : 0;
    }
  const std::int64_t pixels = panel.image.width * panel.image.height;
  return {end_words(panel.low, "below", below, pixels), end_words(panel.high, "above", above, pixels)};
}

void write_picture(const std::string& path, std::span<const Panel> panels, bool false_colour, std::size_t columns) {
  if (columns == 0) columns = panels.size();
  std::int64_t width = 0, height = 0;
  std::vector<std::int64_t> bars;  // of each row
  for (std::size_t first = 0; first < panels.size(); first += columns) {
    std::int64_t across = kMargin, tallest = 0;
    for (const Panel& panel : panels.subspan(first, std::min(columns, panels.size() - first))) {
      across += shown_width(panel) + kMargin;
      tallest = std::max(tallest, shown_height(panel));
    }
    width = std::max(width, across);
    bars.push_back(height + kHead + tallest + kBarGap);
    height = bars.back() + kBar + kFoot;
  }
  mtf::Image page(width, height);
  std::fill_n(page.data(), page.size(), kGround);
  mtf::io::Drawing drawing;
  drawing.false_colour = false_colour;
  std::int64_t x = kMargin, y = kHead;
  for (std::size_t p = 0; p < panels.size(); ++p) {
    const std::size_t row = p / columns;
    if (p > 0 && p % columns == 0) x = kMargin, y = bars[row - 1] + kBar + kFoot + kHead;
    place(panels[p], x, y, bars[row], page, drawing);
    x += shown_width(panels[p]) + kMargin;
  }
  mtf::io::write_annotated_png(path, page.view(), 0.0, 1.0, drawing);
}

}  // namespace apps
