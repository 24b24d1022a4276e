// SPDX-License-Identifier: Apache-2.0
#include "apps/python/steps.h"

#include "mtf/error.h"

namespace apps::python {

mtf::SampleGrid grid_of(const mtf::io::SensorConfig& sensor, std::int64_t width, std::int64_t height,
                        const SampleWords& sample) {
  mtf::SampleGrid grid{width, height, 0.0, 0.0};
  if (sample) {
    const auto um = [&](const std::string& text, mtf::Axis axis) {
      const mtf::Quantity given = mtf::parse_quantity(text, mtf::Dimension::extent);
      const double step = mtf::Extent<double>(given.value, given.unit).um(sensor.system.frame, axis);
      if (!(step > 0.0)) throw mtf::UsageError("sample: " + text + " is not above zero");
      return step;
    };
    grid.step_x_um = um(sample->first, mtf::Axis::x);
    grid.step_y_um = um(sample->second, mtf::Axis::y);
    return grid;
  }
  if (!sensor.scene.sample_x_um || !sensor.scene.sample_y_um)
    throw mtf::UsageError(
        "sample: the spacing of the scene's samples is not known; give sample=\"3.75 um\" (at the focal plane, as an "
        "angle or in pixels), or state it in [scene] of the sensor");
  grid.step_x_um = *sensor.scene.sample_x_um;
  grid.step_y_um = *sensor.scene.sample_y_um;
  return grid;
}

mtf::io::Quantity quantity_of(const std::string& name) {
  using mtf::io::Quantity;
  for (const Quantity quantity :
       {Quantity::radiance, Quantity::photon_radiance, Quantity::temperature, Quantity::counts})
    if (mtf::io::quantity_name(quantity) == name) return quantity;
  throw mtf::UsageError("quantity: '" + name +
                        "' is not known for values in memory (one of radiance, photon_radiance, temperature, counts)");
}

radiometry::OutputStage output_stage(const std::string& name) {
  std::string all;
  for (std::size_t i = 0; i < radiometry::kOutputStageNames.size(); ++i) {
    if (radiometry::kOutputStageNames[i] == name) return static_cast<radiometry::OutputStage>(i);
    all += (all.empty() ? "" : ", ") + std::string(radiometry::kOutputStageNames[i]);
  }
  throw mtf::UsageError("stage: '" + name + "' is not known (one of " + all + ")");
}

}  // namespace apps::python
