// The work of `raywalk-render validate`: renders every true viewpoint and compares it with its
// truth.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/evaluate/connect_error.h"
#include "core/room/room.h"
#include "core/view/view_mode.h"

namespace raywalk {

struct ValidateOptions {
  std::filesystem::path truth{};   // gt.csv
  bool match_exposure = false;     // of views to their truths (exposed_as)
  std::filesystem::path report{};  // directory, created if it is missing
  std::vector<ViewMode> modes{};   // each is rendered at the truths' widths
  ConnectErrorOptions connect{};
};

// Reads the truth, checks that the report can be written, renders, measures, and writes
// `report`/metrics.json (docs/file-formats.md lists its keys) and `report`/index.html, each
// atomically. A stopped run leaves what it measured in `report`/validation.partial, and the same
// call resumes it. Returns a summary for the user. Throws Error before any rendering where the
// input is wrong or the report cannot be written; Interrupted.
std::string validate(const Room& room, const ValidateOptions& options);

}  // namespace raywalk
