// The page of each kind of report, which the build bundles (page/build.mjs): RAYWALK_REPORT in it
// stands for the report's JSON.
#pragma once

#include <string>
#include <string_view>

namespace raywalk {

// `kind`: the stem of a description that raywalk_report_kind (Pages.cmake) names.
std::string_view report_template(std::string_view kind);

}  // namespace raywalk
