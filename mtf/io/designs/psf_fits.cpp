// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/designs/psf_fits.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "mtf/error.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/file_checks.h"
#include "mtf/io/image_io.h"
#include "mtf/units.h"
#include "mtf/words.h"

namespace mtf::io {
namespace {

/// Samples along an axis, as a block of a sensor file holds them and `positions` takes them; planes.
constexpr std::int64_t kMostSamples = 257, kMostPlanes = 4096;
constexpr double kMostDegree = 10.0;

/// With a row and column of zeros behind where their number is even, or the row on top.
Image odd(const Image& samples, bool turn, bool zeros_on_top) {
  Image made(samples.width() / 2 * 2 + 1, samples.height() / 2 * 2 + 1);
  std::fill_n(made.data(), made.size(), 0.0F);
  const std::int64_t top = zeros_on_top ? made.height() - samples.height() : 0;
  for (std::int64_t y = 0; y < samples.height(); ++y)
    std::copy_n(samples.view().row(turn ? samples.height() - 1 - y : y), samples.width(), made.view().row(y + top));
  return made;
}

/// Sum of plane k u^i v^j.
Image sum_of(const std::vector<Image>& planes, int degree, double u, double v) {
  std::vector<double> sum(static_cast<std::size_t>(planes.front().size()));
  auto plane = planes.begin();
  for (int j = 0; j <= degree; ++j)
    for (int i = 0; i <= degree - j; ++i, ++plane) {
      const double weight = std::pow(u, i) * std::pow(v, j);
      for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += weight * static_cast<double>(plane->data()[k]);
    }
  Image image(planes.front().width(), planes.front().height());
  std::ranges::transform(sum, image.data(), [](double value) { return static_cast<float>(value); });
  return image;
}

}  // namespace

bool is_fits(const std::string& path) {
  static_cast<void>(ordinary_file_size(path));
  std::array<char, 9> start{};
  std::ifstream(path, std::ios::binary).read(start.data(), start.size());
  return std::string_view(start.data(), start.size()) == "SIMPLE  =";
}

PsfFits read_psf_fits(const std::string& path, const PsfFitsOptions& options) {
  const std::vector<ChannelInfo> channels = read_info(path).channels;
  auto chosen = channels.begin();
  for (const char* name : {"DET_DIST", "OVERDIST"})  // the last that is there
    if (const auto named = std::ranges::find(channels, name, &ChannelInfo::part_name); named != channels.end())
      chosen = named;
  const ChannelInfo& unit = *chosen;
  const auto count = static_cast<std::size_t>(std::ranges::count(channels, unit.part, &ChannelInfo::part));
  if (std::ssize(channels) > kMostPlanes)
    throw UsageError(path + ": " + plural(std::ssize(channels), "plane") + ", at most " + std::to_string(kMostPlanes) +
                     " are read; cut the cube into pieces");
  std::vector<Image> planes;
  std::map<std::string, std::string> words;
  for (const ChannelInfo& channel : channels) {
    if (channel.part != unit.part) continue;
    ImageFile file = read_image(path, {.channel = channel.name, .part = channel.part});
    words = std::move(file.info.attributes);
    planes.push_back(std::move(file.planes.front()));
    const std::int64_t columns = planes[0].width(), rows = planes[0].height();
    if (const auto side = std::max(columns, rows); side > kMostSamples)
      throw UsageError(path + ": " + std::to_string(side) + " samples along an axis, at most " +
                       std::to_string(kMostSamples) + " are read; compute fewer, or cut off the outer ones");
    if (planes.size() == 1) check_plane_size(path, columns, rows, static_cast<std::int64_t>(count));
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
  const auto samples_a_pixel = number("OVERSAMP") ? number("OVERSAMP") : number("DET_SAMP");
  if (psf.step.empty() && psfex) psf.step = format_double(number("PSF_SAMP").value_or(1.0)) + " px";
  if (psf.step.empty() && number("PIXELSCL")) psf.step = format_double(*number("PIXELSCL")) + " arcsec";
  if (psf.step.empty() && samples_a_pixel) psf.step = format_double(1.0 / *samples_a_pixel) + " px";
  if (psf.step.empty())
    throw UsageError(path +
                     ": the step of its samples is not stated (PSF_SAMP, PIXELSCL, OVERSAMP); give --step \"2 um\"");
  std::vector<std::string>& notes = psf.remarks.notes;
  notes.push_back(path + ": " + plural(std::ssize(planes), "plane") + " of unit " + std::to_string(unit.part) + " " +
                  unit.part_name + ", step " + psf.step + (count < channels.size() ? "; of the file no others" : ""));
  if (psfex || grid || unit.part_name.starts_with("DET_"))
    psf.remarks.warnings.push_back(path +
                                   ": the footprint of the pixel is in these point spreads: leave `footprint` out");
  if (unit.part_name.ends_with("DIST"))
    notes.push_back(path + ": distortion and effects of the detector are in " + unit.part_name);
  if (!psfex && (planes.front().width() % 2 == 0 || planes.front().height() % 2 == 0))
    notes.push_back(path +
                    ": the centre lies between the samples, half a step before the origin: their number is even");

  double degree = 0.0;
  std::array<double, 2> zero{}, scale{1.0, 1.0};
  if (psfex && number("POLNAXIS").value_or(0.0) > 0.0) {
    degree = number("POLDEG1").value_or(-1.0);
    const std::string read = "polynomials of X_IMAGE and Y_IMAGE, in one group, are read; fit the PSF to these";
    if (words["POLNAXIS"] != "2") throw fail("POLNAXIS", read);
    if (words["POLNGRP"] != "1") throw fail("POLNGRP", read);
    if (degree > kMostDegree) throw fail("POLDEG1", "at most 10 is read; fit polynomials of a lower degree");
    if (degree < 0.0 || 2.0 * static_cast<double>(count) != (degree + 1.0) * (degree + 2.0))
      throw fail("POLDEG1", std::to_string(count) + " planes are not those of this degree");
    for (const std::size_t k : {0U, 1U}) {
      const std::string axis = std::to_string(k + 1), name = words["POLNAME" + axis];
      if (std::ranges::none_of(std::array{"", "WIN", "PSF", "MODEL", "PEAK"}, [&](const char* kind) {
            return name == (k == 0 ? "X" : "Y") + std::string(kind) + "_IMAGE";
          }))
        throw fail("POLNAME" + axis, read);
      zero[k] = number("POLZERO" + axis).value_or(0.0);
      scale[k] = number("POLSCAL" + axis).value_or(0.0);
      if (scale[k] == 0.0) throw fail("POLSCAL" + axis, "a number belongs there, and not 0");
      notes.push_back(path + ": fitted to stars from " + significant(zero[k] - 0.5 * std::abs(scale[k]), 6) + " to " +
                      significant(zero[k] + 0.5 * std::abs(scale[k]), 6) + " along " + (k == 0 ? "X" : "Y") +
                      "; beyond, its polynomials are carried on");
    }
  }
  const bool places = grid || degree > 0.0;
  if (places && !options.detector && (options.y_up || psfex))
    throw UsageError(path + ": its places need the size of the detector, frame.format: --detector 2048,2048");
  const auto [columns, rows] = options.detector.value_or(std::array<int, 2>{});
  // From the lower left corner, in pixels.
  const auto add = [&](const Image& image, double x, double y, const std::string& label) {
    PsfPlane plane{.place = {}, .label = label, .samples = odd(image, !options.y_up, psfex && options.y_up)};
    if (places) plane.place = {x, options.y_up ? rows - y : y, "px"};
    if (places && options.detector && (std::min(x, y) < 0.0 || x > columns || y > rows))
      throw UsageError(path + ": " + plane.place->text() + " lies beyond --detector " + size_text(columns, rows) +
                       "; give the size of the detector that its places count pixels of");
    psf.planes.push_back(std::move(plane));
  };
  const int steps = static_cast<int>(std::max(degree, 2.0)) + 2;
  for (int k = 0; degree > 0.0 && k < (steps + 1) * (steps + 1); ++k) {
    const double x = 1.0 * columns * (k % (steps + 1)) / steps, y = 1.0 * rows * (k / (steps + 1)) / steps;
    add(sum_of(planes, static_cast<int>(degree), (x + 0.5 - zero[0]) / scale[0], (y + 0.5 - zero[1]) / scale[1]), x, y,
        "");
  }
  for (std::size_t i = 0; degree == 0.0 && i < count; ++i) {
    const std::string key = "DET_YX" + std::to_string(i), digits = std::to_string(i);
    const std::string spectral = count < 100 ? "WAVELN" : "WVLN";  // a keyword has eight characters
    const auto yx = split_words(words[key], "(), ");
    const auto y = cell_number(yx.empty() ? "" : yx.front()), x = cell_number(yx.empty() ? "" : yx.back());
    if (grid && (yx.size() != 2 || !x || !y)) throw fail(key, "a place (y, x) belongs there");
    const auto wavelength =
        number(count == 1 ? "WAVELEN" : spectral + std::string(8 - spectral.size() - digits.size(), '0') + digits);
    add(planes[i], x.value_or(0.0) + 0.5, y.value_or(0.0) + 0.5,
        wavelength ? significant(*wavelength * 1e6, 6) + " um" : "plane " + std::to_string(i + 1));
  }
  return psf;
}

}  // namespace mtf::io
