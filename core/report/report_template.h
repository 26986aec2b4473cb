// The page of all reports, which the build bundles (page/build.mjs): RAYWALK_REPORT in it stands
// for the report's JSON.
#pragma once

#include <string_view>

namespace raywalk {

std::string_view report_template();

}  // namespace raywalk
