// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a metric needs and neither a sensor nor the study has.

#include <string>

#include "apps/study/metric_rows.h"
#include "apps/study/variant_sensor.h"

namespace study {

/// "no [detector]", "no [conditions] range" ...; "" where the sensor has all that the metric needs.
std::string metric_gap(const MetricChoice& choice, const Study& study, const VariantSensor& sensor);

/// The same for a metric that no level of the axis over `sensor` can have, each with the first levels of other axes;
/// "" where one has it.
std::string metric_gap(const MetricInfo& metric, const Study& study);

}  // namespace study
