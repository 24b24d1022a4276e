// SPDX-License-Identifier: Apache-2.0
#pragma once

// The image of reference_image.h by a second method, fast enough for whole scenes: the same periodic canvas and the
// same exact OTF at every frequency, all in double, with row and column transforms in place of sums. Detector centres
// that form a whole ratio with the canvas are sampled by adding the frequencies that alias onto one another; all others
// by the trigonometric sum itself. Nothing is left out, tabulated or rounded to float.

#include <complex>
#include <functional>
#include <span>
#include <vector>

#include "apps/check/reference_image.h"
#include "mtf/otf/factored_otf.h"

namespace apps::check {

/// h[i] = otf(fx, fy[i]), cycles/mm. Has to be the transform of something real: otf(-f) = conj otf(f); only fx >= 0 is
/// asked for. Called from several threads.
using OtfColumn = std::function<void(double fx, std::span<const double> fy, std::span<std::complex<double>> h)>;

/// Product of the given lists, everything exact, times the correction of the scene's own aperture. Over a band it is
/// the mean over System::band_nodes wavelengths. Keeps a copy of the system.
OtfColumn exact_otf(const mtf::System<double>& system, std::vector<mtf::Stage> stages,
                    const mtf::SceneAperture& aperture, const mtf::SampleGrid& in);

/// The filtered, sampled image, row-major, out.width x out.height. `scene` has the size of `in`; threads 0 = all cores.
std::vector<double> reference_image_fft(mtf::ImageView<const float> scene, const mtf::SampleGrid& in,
                                        const mtf::SampleGrid& out, const OtfColumn& otf, mtf::Border border,
                                        double border_value, int threads);
std::vector<double> reference_image_fft(mtf::ImageView<const double> scene, const mtf::SampleGrid& in,
                                        const mtf::SampleGrid& out, const OtfColumn& otf, mtf::Border border,
                                        double border_value, int threads);
/// The same for an OTF one frequency at a time.
std::vector<double> reference_image_fft(mtf::ImageView<const float> scene, const mtf::SampleGrid& in,
                                        const mtf::SampleGrid& out, const Otf& otf, mtf::Border border,
                                        double border_value, int threads);

/// What mtf::SensorPlan approximates: presample OTF and sampling at the pitch, then readout and postsample filters on
/// the detector grid under the same border rule, a constant border value being multiplied by the presample gain. Size:
/// detector_grid(system, in).
std::vector<double> reference_sensor_image(const mtf::System<double>& system, mtf::ImageView<const float> scene,
                                           const mtf::SampleGrid& in, const mtf::SceneAperture& aperture,
                                           mtf::Border border, double border_value, int threads);

}  // namespace apps::check
