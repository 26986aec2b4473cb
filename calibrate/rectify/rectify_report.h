// rectify.json and rectify.html.
#pragma once

#include <filesystem>

#include "calibrate/rectify/rectify_set.h"
#include "core/report/html_page.h"

namespace raywalk::calibrate {

// Writes both into OUT. `grid` may be null. Throws Error if a file cannot be written.
void write_rectify_report(const CaptureSet& set, const FramePoses& poses, const GridResult* grid,
                          const RectifyResult& result, const std::filesystem::path& out);

// A part shared with other pages: the overlays, read from OUT.
void add_overlays(const CaptureSet& set, const RectifyResult& result,
                  const std::filesystem::path& out, HtmlPage* page);

// "raywalk-build-lf pack --frames OUT/poses.csv ...", the next step.
std::string pack_command(const RectifyResult& result, const std::filesystem::path& out);

}  // namespace raywalk::calibrate
