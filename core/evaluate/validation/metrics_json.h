// The measurements of a validation as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/evaluate/validation/validate.h"

namespace raywalk {

// The document of metrics.json, whose keys docs/file-formats.md lists. "name" is the stem of the
// truth's file; PSNRs are at most kMaxPsnrDb. A value that was not measured (no viewpoint had a
// readable overlap) is null in the file.
nlohmann::ordered_json metrics_document(const Validation& validation);

}  // namespace raywalk
