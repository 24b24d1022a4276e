// SPDX-License-Identifier: Apache-2.0
#include "mtf/field/throughput.h"

#include <algorithm>
#include <span>

#include "mtf/components/wavefront.h"
#include "mtf/error.h"
#include "mtf/parallel.h"

namespace mtf {

Image throughput_image(const System<double>& system, int threads) {
  const auto& list = system.list(Stage::presample);
  const auto lens = std::ranges::find_if(list, [](const Entry<double>& entry) {
    const auto* wavefront = entry.component.get_if<Wavefront<double>>();
    return wavefront != nullptr && wavefront->vignetting_rim && wavefront->vignetting_shift;
  });
  if (lens == list.end())
    throw UsageError("no wavefront of [[presample]] has vignetting_rim and vignetting_shift; add them to it");
  const auto* wavefront = lens->component.get_if<Wavefront<double>>();
  const auto fields = lens->component.fields();
  const double obscuration = obscuration_of(wavefront->obscuration, system.context());
  // What changes over the field of each, alone: System::at would copy all else for every pixel.
  const auto numbers_of = [&](std::string_view name) {
    std::vector<FieldNumber<double>> numbers = system.field.numbers;
    std::erase_if(numbers, [&](const FieldNumber<double>& number) {
      return number.entry != static_cast<std::size_t>(lens - list.begin()) || fields[number.field].info->name != name;
    });
    return numbers;
  };
  const auto rims = numbers_of("vignetting_rim"), shifts = numbers_of("vignetting_shift"),
             holes = numbers_of("obscuration");
  const auto at = [&](double axis, std::span<const FieldNumber<double>> numbers, const FieldPoint<double>& q) {
    for (const FieldNumber<double>& number : numbers) axis += system.change(number, q);
    return axis;
  };
  static_cast<void>(system.field_point(0.0, 0.0));  // that there is a format
  Image shares(system.frame.columns, system.frame.rows);
  constexpr std::int64_t kRowsAtOnce = 16;
  parallel_for_each(shares.height(), kRowsAtOnce, threads, [&](std::int64_t y) {
    for (std::int64_t x = 0; x < shares.width(); ++x) {
      const FieldPoint<double> q = system.field_point(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
      const PupilRim<double> rim{at(*wavefront->vignetting_rim, rims, q), at(*wavefront->vignetting_shift, shifts, q)};
      shares.at(x, y) = static_cast<float>(pupil_share(rim, at(obscuration, holes, q)));
    }
  });
  return shares;
}

}  // namespace mtf
