// SPDX-License-Identifier: Apache-2.0
#pragma once

// What Rigor::measure has learnt on this machine: FFTW's wisdom, and run times of the methods of a plan. It is kept for
// the life of the process, and as text to be stored per host.

#include <functional>
#include <optional>
#include <string>

namespace mtf {

/// Milliseconds of one method on one piece of work, when it has been measured before. Thread-safe.
std::optional<double> measured_ms(const std::string& work);
void remember_ms(const std::string& work, double ms);

/// Smallest of a few runs, after one that is not counted; long runs are repeated less often.
double time_ms(const std::function<void()>& run);

/// All of it as text, and back. False when the text is something else, or damaged: nothing is taken from it then.
std::string export_measured();
bool import_measured(const std::string& text);

}  // namespace mtf
