// The measurements of a validation as JSON.
#pragma once

#include <optional>
#include <string>

#include "core/judge/validation/before_after.h"
#include "core/judge/validation/validate.h"

namespace raywalk {

// metrics.json:
//   {"volume": str,
//    "views": [{"name", "x_m", "z_m", "generation", "connection", "k_deg", "layers", "enlargement",
//               "psnr_db", "ws_psnr_db", "ssim", "fsim", "render_ms"}],
//    "connection_error": [{"connection": "lfu"|"rayspace360"|"hybrid", "k_deg", "generation",
//                          "e_connect", "e_connect_common", "coverage", "common_share"}],
//    "means": {<generation>: {"psnr_db", "ws_psnr_db", "ssim", "fsim"}},
//    "before_after": only of two rooms, as before_after_json}
// "name" is the stem of the truth's file; "layers" is 0 in initial views; PSNRs are at most
// kMaxPsnrDb. A value that was not measured (no viewpoint had a readable overlap) is null.
std::string metrics_json(const Validation& validation,
                         const std::optional<BeforeAfter>& compared = std::nullopt);

}  // namespace raywalk
