// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a metric needs and neither the sensor nor the study has.

#include <string>

#include "apps/study/design/metric_rows.h"
#include "apps/study/design/variant_sensor.h"

namespace study {

/// "no [detector]", "no [conditions] range" ...; "" where the sensor has all that the metric needs.
std::string metric_gap(const MetricChoice& choice, const Study& study, const VariantSensor& sensor);

/// The same for a study: why no sensor file of its axis over `sensor` has what the metric needs, the other axes being
/// at their first values; "" where one of the files has it.
std::string metric_gap(const MetricInfo& metric, const Study& study);

}  // namespace study
