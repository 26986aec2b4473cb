// Dials in JSON: choices by name, numbers as numbers, 0 of a dial with a word for it as that word.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/files/checked_json.h"
#include "core/view/view_options.h"

namespace raywalk {

// The value of a dial, and back. Throws Error as CheckedJson does, also for the width 0.
nlohmann::ordered_json json_of(const Dial& dial, const ViewOptions& options);
double value_from(const Dial& dial, const CheckedJson& json);

// The dials that a trade varies, {"generation": "hlf-vd", "k_deg": 76.0, ...}, and back; the others
// are as in ViewOptions(). Members that are no dials are ignored. Throws as value_from() does.
nlohmann::ordered_json swept_dials_json(const ViewOptions& options);
ViewOptions options_from(const CheckedJson& json);

}  // namespace raywalk
