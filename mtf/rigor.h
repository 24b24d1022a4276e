// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace mtf {

/// How much work goes into choosing a method and its transforms. `estimate` is reproducible between runs; `measure`
/// times the candidates, so that planning is slow and runs are fast.
enum class Rigor { estimate, measure };

}  // namespace mtf
