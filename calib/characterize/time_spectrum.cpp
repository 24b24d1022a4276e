// SPDX-License-Identifier: Apache-2.0
#include "calib/characterize/time_spectrum.h"

#include <algorithm>
#include <numeric>

#include "calib/characterize/line_spectrum.h"

namespace calib {
namespace {

constexpr std::int64_t kMostPixels = 1024, kRunFrames = 1024;

void add_to(std::vector<double>& sum, const std::vector<double>& power) {
  sum.resize(power.size());
  for (std::size_t k = 0; k < power.size(); ++k) sum[k] += power[k];
}

}  // namespace

TimeSeries::TimeSeries(std::int64_t width, std::int64_t height) {
  std::int64_t step = (width * height + kMostPixels - 1) / kMostPixels;
  while (std::gcd(step, width) != 1) ++step;  // else some columns have no pixel
  for (std::int64_t i = 0; i < width * height; i += step) places_.push_back(i);
}

void TimeSeries::add(mtf::ImageView<const float> frame, double mean) {
  const auto value = [&](std::int64_t place) { return frame.at(place % frame.width, place / frame.width); };
  if (first_.empty()) std::ranges::transform(places_, std::back_inserter(first_), value);
  for (std::size_t i = 0; i < places_.size(); ++i) run_.push_back(value(places_[i]) - first_[i]);
  run_.push_back(static_cast<float>(mean));
  if (std::ssize(run_) < kRunFrames * (std::ssize(places_) + 1)) return;
  take_run(sum_);
  run_.clear();
}

TimeSpectra TimeSeries::spectra() const {
  TimeSpectra result = sum_;
  if (result.runs == 0) take_run(result);
  for (auto* const powers : {&result.pixels, &result.means})
    for (double& power : *powers) power /= static_cast<double>(result.runs);
  return result;
}

void TimeSeries::take_run(TimeSpectra& sum) const {
  const std::int64_t pixels = std::ssize(places_), lines = pixels + 1;
  sum.length = std::ssize(run_) / lines;
  sum.of_pixels = pixels;
  ++sum.runs;
  add_to(sum.pixels, line_spectrum({run_.data(), pixels, sum.length, lines}, LineAxis::columns));
  add_to(sum.means, line_spectrum({run_.data() + pixels, 1, sum.length, lines}, LineAxis::columns));
}

}  // namespace calib
