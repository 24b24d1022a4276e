// SPDX-License-Identifier: Apache-2.0
#include "radiometry/stages/noise/fixed_pattern.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "radiometry/light/pixel_rules.h"

namespace radiometry {
namespace {

void require_rms(const char* what, double rms, double most) {
  if (!(rms >= 0.0 && rms <= most))
    throw mtf::UsageError(std::string(what) + " of " + mtf::format_double(rms) + " rms; it has to be from 0 to " +
                          mtf::format_double(most));
}

void require_defects(const Defects& defects) {
  require_valid("defects", defects);
  if (defects.dead_fraction + defects.hot_fraction > 1.0)
    throw mtf::UsageError("defects: dead_fraction " + mtf::format_double(defects.dead_fraction) + " and hot_fraction " +
                          mtf::format_double(defects.hot_fraction) +
                          " are more than all pixels together; lower one of them");
}

template <class Combine>
void with_map(mtf::ImageView<float> image, mtf::ImageView<const float> map, int threads, Combine combine) {
  if (map.width != image.width || map.height != image.height)
    throw mtf::UsageError("a map of " + size_of(map.width, map.height) + " pixels for an image of " +
                          size_of(image.width, image.height) + "; give one of its size");
  for_each_pixel(image, map, threads, combine);
}

}  // namespace

std::vector<float> line_numbers(double rms, const NoiseKey& key, Stream stream, std::int64_t first,
                                std::int64_t count) {
  std::vector<float> numbers(static_cast<std::size_t>(count));
  gaussian_row({key, stream, 0}, first, count, numbers.data());
  for (float& number : numbers) number *= static_cast<float>(rms);
  return numbers;
}

void responsivity_map(mtf::ImageView<float> map, const ResponsivityRms& rms, std::uint64_t seed, Origin origin,
                      int threads) {
  for (const double one : {rms.pixel, rms.row, rms.column}) require_rms("responsivity non-uniformity", one, 1.0);
  require_on_detector(origin, map.width, map.height);
  const auto s = static_cast<float>(rms.pixel);
  const std::vector<float> rows = line_numbers(rms.row, {seed, 0}, Stream::prnu_row, origin.y, map.height),
                           columns = line_numbers(rms.column, {seed, 0}, Stream::prnu_column, origin.x, map.width);
  mtf::parallel_for(map.height, kRowsAtOnce, threads, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t y = begin; y < end; ++y) {
      float* row = map.row(y);
      gaussian_row({{seed, 0}, Stream::prnu, static_cast<std::uint32_t>(origin.y + y)}, origin.x, map.width, row);
      const float of_row = 1.0F + rows[static_cast<std::size_t>(y)];
      for (std::int64_t x = 0; x < map.width; ++x)
        row[x] = std::max(0.0F, of_row + columns[static_cast<std::size_t>(x)] + s * row[x]);
    }
  });
}

void offset_map(mtf::ImageView<float> map, double rms, std::uint64_t seed, Origin origin, int threads) {
  for (std::int64_t y = 0; y < map.height; ++y) std::fill_n(map.row(y), map.width, 0.0F);
  add_gaussian(map, rms, {seed, 0}, Stream::dsnu, origin, threads);
}

void dark_current_map(mtf::ImageView<float> map, double rms, std::uint64_t seed, Origin origin, int threads) {
  require_rms("dark-current non-uniformity", rms, 10.0);
  const double s2 = std::log1p(rms * rms);
  for (std::int64_t y = 0; y < map.height; ++y) std::fill_n(map.row(y), map.width, 0.0F);
  add_gaussian(map, std::sqrt(s2), {seed, 0}, Stream::dcnu, origin, threads);
  for_each_pixel(map, threads, [&](double value) { return static_cast<float>(std::exp(value - 0.5 * s2)); });
}

void require_numbers(const std::string& name, mtf::ImageView<const float> map, float least, Origin origin) {
  for (std::int64_t y = 0; y < map.height; ++y)
    for (std::int64_t x = 0; x < map.width; ++x)
      if (!(map.at(x, y) >= least && std::isfinite(map.at(x, y))))
        throw mtf::UsageError(name + " has " + mtf::format_double(static_cast<double>(map.at(x, y))) + " at pixel " +
                              std::to_string(origin.x + x) + ", " + std::to_string(origin.y + y) +
                              (least == 0.0F ? "; factors are 0 or above and finite" : "; offsets are finite"));
}

void multiply_by(mtf::ImageView<float> image, mtf::ImageView<const float> map) {
  with_map(image, map, 1, std::multiplies<float>());
}

void add_map(mtf::ImageView<float> image, mtf::ImageView<const float> map, int threads) {
  with_map(image, map, threads, std::plus<float>());
}

void add_row_noise(mtf::ImageView<float> image, double rms, const NoiseKey& key, Stream stream, Origin origin) {
  require_rms("row noise", rms, 1e30);
  require_on_detector(origin, image.width, image.height);
  if (rms == 0.0) return;
  const std::vector<float> numbers = line_numbers(rms, key, stream, origin.y, image.height);
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x) image.at(x, y) += numbers[static_cast<std::size_t>(y)];
}

void add_column_noise(mtf::ImageView<float> image, double rms, const NoiseKey& key, Stream stream, Origin origin) {
  require_rms("column noise", rms, 1e30);
  require_on_detector(origin, image.width, image.height);
  if (rms == 0.0) return;
  const std::vector<float> numbers = line_numbers(rms, key, stream, origin.x, image.width);
  for (std::int64_t y = 0; y < image.height; ++y)
    for (std::int64_t x = 0; x < image.width; ++x) image.at(x, y) += numbers[static_cast<std::size_t>(x)];
}

std::vector<DefectivePixel> find_defects(std::int64_t width, std::int64_t height, const Defects& defects,
                                         std::uint64_t seed, Origin origin, int threads) {
  require_defects(defects);
  require_on_detector(origin, width, height);
  const double dead = defects.dead_fraction, hot = defects.hot_fraction;
  if (dead + hot == 0.0) return {};
  std::vector<std::vector<DefectivePixel>> rows(static_cast<std::size_t>(height));
  mtf::parallel_for_each(height, kRowsAtOnce, threads, [&](std::int64_t y) {
    std::vector<DefectivePixel>& found = rows[static_cast<std::size_t>(y)];
    const RandomRow random{{seed, 0}, Stream::defects, static_cast<std::uint32_t>(origin.y + y)};
    for (std::int64_t x = 0; x < width; ++x) {
      // [0, dead) is dead; [dead, dead + hot) is hot, the place in there giving the excess by inversion.
      const double u = uniform_at(random, static_cast<std::uint64_t>(origin.x + x)).u;
      if (u < dead)
        found.push_back({x, y, true, 0.0F});
      else if (u < dead + hot)
        found.push_back({x, y, false, static_cast<float>(-defects.hot_e * std::log1p(-(u - dead) / hot))});
    }
  });
  std::vector<DefectivePixel> found;
  for (const auto& row : rows) found.insert(found.end(), row.begin(), row.end());
  return found;
}

void apply_defects(mtf::ImageView<float> image, std::span<const DefectivePixel> pixels) {
  for (const DefectivePixel& pixel : pixels) {
    if (pixel.x < 0 || pixel.y < 0 || pixel.x >= image.width || pixel.y >= image.height)
      throw mtf::UsageError("defects: pixel " + std::to_string(pixel.x) + ", " + std::to_string(pixel.y) +
                            " is outside an image of " + size_of(image.width, image.height));
    float& value = image.at(pixel.x, pixel.y);
    value = pixel.dead ? 0.0F : value + pixel.excess_e;
  }
}

}  // namespace radiometry
