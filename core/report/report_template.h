// The page of each kind of report, which the build bundles (page/build.mjs): RAYWALK_REPORT in it
// stands for the report's JSON.
#pragma once

#include <string>
#include <string_view>

namespace raywalk {

// `kind`: a file of page/src/reports.
std::string_view report_template(std::string_view kind);

}  // namespace raywalk
