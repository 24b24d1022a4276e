// SPDX-License-Identifier: Apache-2.0
#pragma once

// The words of messages and tables, as the whole of apps says them.

#include "mtf/words.h"

namespace apps {

using mtf::fixed;
using mtf::joined;
using mtf::one_line;
using mtf::plural;
using mtf::significant;

}  // namespace apps
