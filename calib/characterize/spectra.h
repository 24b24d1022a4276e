// SPDX-License-Identifier: Apache-2.0
#pragma once

// Spectra of fixed patterns, as EMVA 1288 (release 4, section 8) shows them: the periodograms of all rows, or of all
// columns, averaged,
//   P_k = mean over the rows of |sum over x of p(x) exp(-2 pi i k x / n)|^2 / n,   k/n cycles per pixel
// A white pattern has its variance at every frequency; the mean of each row, at k = 0, is left out.
//
// Spectra of the noise in time: the periodograms of the values of a pixel in successive frames, averaged over pixels,
// and that of the means of frames,
//   P_k = |sum over t of x(t) exp(-2 pi i k t / T)|^2 / T,   k/T cycles per frame
// White noise has its variance at every frequency. 1/f noise and lag rise towards low ones, a lamp that flickers
// regularly is a peak. The pixels are about 1024, in all columns and rows where these are fewer. Of more than 1024
// frames the spectra are averages over whole runs of 1024, so that the memory is 4 MB for any number.

#include <cstdint>
#include <vector>

#include "mtf/image.h"

namespace calib {

enum class LineAxis { rows, columns };

/// P_1 to P_(n/2).
std::vector<double> line_spectrum(mtf::ImageView<const float> plane, LineAxis axis);

struct TimeSpectra {
  std::int64_t length = 0, runs = 0;  ///< T, and how many of them
  std::int64_t of_pixels = 0;         ///< how many
  std::vector<double> pixels, means;  ///< P_1 to P_(T/2), counts^2
};

/// The frames that the spectra are of.
class TimeSeries {
 public:
  TimeSeries(std::int64_t width, std::int64_t height);
  /// `mean`: of the frame, about any number that is the same for all.
  void add(mtf::ImageView<const float> frame, double mean);
  TimeSpectra spectra() const;

 private:
  void take_run(TimeSpectra& sum) const;

  std::vector<std::int64_t> places_;  ///< of the pixels, along rows
  std::vector<float> first_;          ///< their values in the first frame, which are taken from all
  std::vector<float> run_;            ///< of each frame of the run those of the pixels, then the mean
  TimeSpectra sum_;                   ///< over the runs that are whole
};

}  // namespace calib
