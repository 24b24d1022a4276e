// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "mtf/system.h"

namespace mtf {

/// True when the list of that stage has the same OTF in both systems: equal kinds and values in the same order, and
/// equal frame, optics and band around them. Labels and names do not count. False may be said of OTFs that are equal
/// all the same: the integration time matters to motion only, but is compared for every list that is not empty.
bool same_list(const System<double>& a, const System<double>& b, Stage stage);

/// True when both are of one kind and have the same values.
bool same_component(const Component<double>& a, const Component<double>& b);
/// True when frame, optics, air and band, around any component, are the same.
bool same_surroundings(const System<double>& a, const System<double>& b);

}  // namespace mtf
