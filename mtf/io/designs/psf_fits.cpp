// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/designs/psf_fits.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/image_io.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

/// Along an axis, as `psf` and its `positions` take them.
constexpr std::int64_t kMostSamples = 1025, kMostOfPlaces = 257;

/// With a row and column of zeros behind where their number is even.
Image odd(const Image& samples, bool turn) {
  Image made(samples.width() / 2 * 2 + 1, samples.height() / 2 * 2 + 1);
  std::fill_n(made.data(), made.size(), 0.0F);
  for (std::int64_t y = 0; y < samples.height(); ++y)
    std::copy_n(samples.view().row(turn ? samples.height() - 1 - y : y), samples.width(), made.view().row(y));
  return made;
}

/// Sum of plane k u^i v^j.
Image sum_of(const std::vector<Image>& planes, int degree, double u, double v) {
  std::vector<double> sum(static_cast<std::size_t>(planes.front().size()));
  auto plane = planes.begin();
  for (int j = 0; j <= degree; ++j)
    for (int i = 0; i <= degree - j; ++i, ++plane)
      for (std::size_t k = 0; k < sum.size(); ++k)
        sum[k] += std::pow(u, i) * std::pow(v, j) * static_cast<double>(plane->data()[k]);
  Image image(planes.front().width(), planes.front().height());
  std::ranges::transform(sum, image.data(), [](double value) { return static_cast<float>(value); });
  return image;
}

}  // namespace

bool is_fits(const std::string& path) {
  std::array<char, 9> start{};
  std::ifstream(path, std::ios::binary).read(start.data(), start.size());
  return std::string_view(start.data(), start.size()) == "SIMPLE  =";
}

PsfFits read_psf_fits(const std::string& path, const PsfFitsOptions& options) {
  const std::vector<ChannelInfo> channels = read_info(path).channels;
  const auto named = std::ranges::find(channels, "OVERDIST", &ChannelInfo::part_name);
  const ChannelInfo& unit = named == channels.end() ? channels.front() : *named;
  const auto count = static_cast<std::size_t>(std::ranges::count(channels, unit.part, &ChannelInfo::part));
  std::vector<Image> planes;
  std::map<std::string, std::string> words;
  for (const ChannelInfo& channel : channels) {
    if (channel.part != unit.part) continue;
    ImageFile file = read_image(path, {.channel = channel.name, .part = channel.part});
    words = std::move(file.info.attributes);
    planes.push_back(std::move(file.planes.front()));
  }
  const auto fail = [&](const std::string& key, const std::string& why) {
    return UsageError(path + ": " + key + " = " + printable(words[key], 40) + ": " + why);
  };
  const auto number = [&](const std::string& key) {
    const auto value = cell_number(words[key]);
    if (!words[key].empty() && (!value || !std::isfinite(*value))) throw fail(key, "a number belongs there");
    return value;
  };

  PsfFits psf{.step = options.step};
  const bool psfex = unit.part_name == "PSF_DATA", grid = words.contains("DET_YX0");
  const auto samples_a_pixel = number("DET_SAMP") ? number("DET_SAMP") : number("OVERSAMP");
  if (psf.step.empty() && psfex) psf.step = format_double(number("PSF_SAMP").value_or(1.0)) + " px";
  if (psf.step.empty() && number("PIXELSCL")) psf.step = format_double(*number("PIXELSCL")) + " arcsec";
  if (psf.step.empty() && samples_a_pixel) psf.step = format_double(1.0 / *samples_a_pixel) + " px";
  if (psf.step.empty())
    throw UsageError(path +
                     ": the step of its samples is not stated (PSF_SAMP, PIXELSCL, DET_SAMP); give --step \"2 um\"");
  std::vector<std::string>& notes = psf.remarks.notes;
  notes.push_back(path + ": " + plural(std::ssize(planes), "plane") + " of unit " + std::to_string(unit.part) + " " +
                  unit.part_name + ", step " + psf.step + (count < channels.size() ? "; of the file no others" : ""));
  if (psfex || grid)
    psf.remarks.warnings.push_back(path +
                                   ": the footprint of the pixel is in these point spreads: leave `footprint` out");
  else if (unit.part_name == "OVERDIST")
    notes.push_back(path + ": distortion and effects of the detector are in OVERDIST");
  if (planes.front().width() % 2 == 0 || planes.front().height() % 2 == 0)
    notes.push_back(path +
                    ": the centre lies between the samples, half a step before the origin: their number is even");

  double degree = 0.0;
  std::array<double, 2> zero{}, scale{1.0, 1.0};
  if (psfex && number("POLNAXIS").value_or(0.0) > 0.0) {
    degree = number("POLDEG1").value_or(-1.0);
    if (words["POLNAXIS"] != "2" || words["POLNGRP"] != "1" || !words["POLNAME1"].starts_with("X") ||
        !words["POLNAME2"].starts_with("Y"))
      throw fail("POLNAXIS", "polynomials of X and Y of the image alone are read (POLNAME1, POLNAME2, POLNGRP = 1)");
    if (degree < 0.0 || 2.0 * static_cast<double>(count) != (degree + 1.0) * (degree + 2.0))
      throw fail("POLDEG1", std::to_string(count) + " planes are not those of this degree");
    for (const std::size_t k : {0U, 1U}) {
      const std::string axis = std::to_string(k + 1);
      zero[k] = number("POLZERO" + axis).value_or(0.0);
      scale[k] = number("POLSCAL" + axis).value_or(0.0);
      if (scale[k] == 0.0) throw fail("POLSCAL" + axis, "a number belongs there, and not 0");
      notes.push_back(path + ": fitted to stars from " + significant(zero[k] - 0.5 * std::abs(scale[k]), 6) + " to " +
                      significant(zero[k] + 0.5 * std::abs(scale[k]), 6) + " along " + (k == 0 ? "X" : "Y") +
                      "; beyond, its polynomials are carried on");
    }
  }
  const bool places = grid || degree > 0.0;
  if (const auto side = std::max(planes[0].width(), planes[0].height()); side > (places ? kMostOfPlaces : kMostSamples))
    throw UsageError(path + ": " + std::to_string(side) +
                     " samples along an axis, at most 1025, of places 257, are read; compute fewer");
  if (places && !options.detector && (options.y_up || psfex))
    throw UsageError(path + ": its places need the size of the detector, frame.format: --detector 2048,2048");
  const auto [columns, rows] = options.detector.value_or(std::array<int, 2>{});
  // From the lower left corner, in pixels.
  const auto add = [&](const Image& image, double x, double y, const std::string& label) {
    PsfPlane plane{.place = {}, .label = label, .samples = odd(image, !options.y_up)};
    if (places) plane.place = {x, options.y_up ? rows - y : y, "px"};
    psf.planes.push_back(std::move(plane));
  };
  const int steps = static_cast<int>(std::max(degree, 2.0)) + 2;
  for (int k = 0; degree > 0.0 && k < (steps + 1) * (steps + 1); ++k) {
    const double x = 1.0 * columns * (k % (steps + 1)) / steps, y = 1.0 * rows * (k / (steps + 1)) / steps;
    add(sum_of(planes, static_cast<int>(degree), (x + 0.5 - zero[0]) / scale[0], (y + 0.5 - zero[1]) / scale[1]), x, y,
        "");
  }
  for (std::size_t i = 0; degree == 0.0 && i < count; ++i) {
    const std::string key = "DET_YX" + std::to_string(i), digits = (i < 10 ? "0" : "") + std::to_string(i);
    const auto yx = split_words(words[key], "(), ");
    const auto y = cell_number(yx.empty() ? "" : yx.front()), x = cell_number(yx.empty() ? "" : yx.back());
    if (grid && (yx.size() != 2 || !x || !y)) throw fail(key, "a place (y, x) belongs there");
    const auto wavelength = number(count == 1 ? "WAVELEN" : "WAVELN" + digits);
    add(planes[i], x.value_or(0.0) + 0.5, y.value_or(0.0) + 0.5,
        wavelength ? significant(*wavelength * 1e6, 6) + " um" : "plane " + std::to_string(i + 1));
  }
  return psf;
}

}  // namespace mtf::io
