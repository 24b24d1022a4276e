// SPDX-License-Identifier: Apache-2.0
#include "radiometry/performance/condition_lines.h"

#include "mtf/units.h"
#include "radiometry/performance/acquisition.h"
#include "radiometry/performance/contrast_threshold.h"

namespace radiometry {

namespace {

using mtf::format_double;

std::string name_of(Psychometric law) { return std::string(kPsychometricNames[static_cast<std::size_t>(law)]); }

}  // namespace

std::vector<std::string> condition_lines(const FiguresOfObservers& figures, const Conditions& c,
                                         const std::optional<Viewing<double>>& viewing, const std::string& air,
                                         const std::string& frame_rate) {
  std::vector<std::string> lines;
  if (figures.bars || figures.johnson)
    lines.push_back("observer of bars: signal-to-noise ratio " + format_double(c.snr_threshold) + ", eye time " +
                    format_double(c.eye_time_s) + " s, " +
                    (c.frame_rate_hz      ? format_double(*c.frame_rate_hz) + " Hz"
                     : frame_rate.empty() ? "a frame each frame time"
                                          : frame_rate));
  if (figures.ttp) {
    const Observer<double> observer;
    const auto model = static_cast<std::size_t>(observer.model);
    lines.push_back("observer of ttp: " + std::string(mtf::kContrastModelNames[model]) + ", " +
                    std::to_string(observer.eyes) + " eyes, noise of NVThermIP (alpha " +
                    format_double(kAlphaNvThermIp) + "), eye time " + format_double(c.eye_time_s) + " s; display of " +
                    format_double(c.luminance_cd_m2) + " cd/m^2, " + format_double(c.scene_contrast_k) +
                    " K from dark to mean, " +
                    (viewing ? "magnification " + mtf::three_digits(viewing->magnification) + ", picture of " +
                                   mtf::three_digits(viewing->field_deg) + " deg" +
                                   (c.magnification ? "" : " with the field of view of the sensor file")
                             : "magnification not given"));
  }
  if (figures.johnson || figures.ttp)
    lines.push_back("target: " + (c.target_size_m ? format_double(*c.target_size_m) + " m, " : "") +
                    (c.contrast_k ? format_double(*c.contrast_k) + " K warmer than " : "contrast not given, ") +
                    "its background of " + format_double(c.temperature_k) + " K");
  const auto three = [](double a, double b, double d) {
    return format_double(a) + ", " + format_double(b) + ", " + format_double(d);
  };
  if (figures.ttp)
    lines.push_back("ttp: V50 " + three(c.v50_detect, c.v50_recognise, c.v50_identify) +
                    " to detect, recognise, identify; probability " + format_double(c.probability) + ", law " +
                    name_of(Psychometric::ttp_nvthermip));
  if (figures.johnson)
    lines.push_back("johnson: N50 " + three(kN50[0], kN50[1], kN50[2]) +
                    " of the 2-D MRTD to detect, recognise, identify, up to Nyquist; probability " +
                    format_double(c.probability) + ", law " + name_of(Psychometric::johnson));
  if (figures.johnson && figures.ttp)
    lines.push_back(
        "johnson and ttp differ: Johnson's ranges end at the Nyquist frequency, TTP goes on to the optical cutoff; "
        "neither counts aliasing, so TTP flatters an under-sampled camera");
  if (!lines.empty() && !air.empty()) lines.push_back("air: " + air);
  return lines;
}

}  // namespace radiometry
