// The work of `raywalk-render validate`: renders every true viewpoint and compares it with its
// truth.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/evaluate/metrics/silhouettes.h"
#include "core/evaluate/validation/comparison_pictures.h"
#include "core/evaluate/validation/connect_error.h"
#include "core/evaluate/validation/quarter_scores.h"
#include "core/evaluate/validation/truth_views.h"
#include "core/evaluate/validation/validation_partial.h"
#include "core/evaluate/validation/view_scores.h"
#include "core/room/room.h"
#include "core/view/view_mode.h"

namespace raywalk {

// One truth rendered in one mode.
struct ValidatedView {
  std::size_t truth = 0;  // index into Validation::truths
  std::size_t mode = 0;   // index into Validation::modes
  ViewReport report{};
  ViewScores scores{};
  SilhouetteScores silhouettes{};        // not measured where the truth has no distances
  std::vector<QuarterScore> quarters{};  // the same sides in the same order in every mode
};

// A truth and its views as thumbnails for the report.
struct PictureSample {
  std::size_t truth = 0;                  // index into Validation::truths
  cv::Mat truth_picture{};                // shrunk for the page
  std::vector<ViewComparison> by_mode{};  // in the order of Validation::modes
};

struct Validation {
  std::string volume{};       // the room
  std::string distances{};    // in use in the room: Room::distances_origin()
  int captured_width_px = 0;  // of its panoramas; wider views are enlarged
  std::vector<TruthView> truths{};
  std::vector<ViewMode> modes{};
  std::vector<ValidatedView> views{};            // truth by truth, within it mode by mode
  std::vector<PictureSample> samples{};          // nearest to a line first
  std::vector<ConnectError> connection_error{};  // empty where the room has no cell
};

// Renders and scores every truth in every mode at the truth's width (mode.options.width is
// ignored). A few are kept as pictures, spread over the distance from the line. Views found in
// `partial` are not rendered again, the others are added to it. connection_error is left empty.
// Throws Error as Renderer and read_panorama do; Interrupted.
Validation validate_views(const Room& room, std::vector<TruthView> truths,
                          std::vector<ViewMode> modes, const ValidationPartial& partial);

// The connection error of every generation in `modes`: the room's stored one (connect_error_file.h)
// if it was measured with these options, else that in the directory `kept_in`, else measured now
// and stored there. Empty where the room has no cell.
std::vector<ConnectError> connection_errors(
    const Room& room, std::span<const ViewMode> modes, const ConnectErrorOptions& options,
    const std::optional<std::filesystem::path>& kept_in = std::nullopt);

// Of the widest true view; 0 without.
int widest_truth_px(const Validation& validation);

// How many times wider than captured the detail of a view is shown; above 1 it is enlarged.
double enlargement_at(const Validation& validation, int width_px);

// Mean scores of the views of one mode.
ViewScores mean_scores(const Validation& validation, std::size_t mode);
SilhouetteScores mean_silhouettes(const Validation& validation, std::size_t mode);
// Whether a truth has distances.
bool measures_silhouettes(const Validation& validation);

struct ValidateOptions {
  std::filesystem::path truth{};   // gt.csv; empty: only connection errors, of two rooms
  std::filesystem::path before{};  // another room of the place, to compare with; empty: none
  std::filesystem::path report{};  // directory, created if it is missing
  std::vector<ViewMode> modes{};
  ConnectErrorOptions connect{};
};

// Reads the truth, checks that the report can be written, renders, measures, and writes
// `report`/metrics.json and `report`/index.html, each atomically. A stopped run leaves what it
// measured in `report`/validation.partial, and the same call resumes it. The room before is
// measured in the same modes, initial views only if it has no distances; its measurements are the
// key "before". Returns a summary for the user. Throws UsageError without a truth and another room;
// Error before any rendering where the input is wrong or the report cannot be written; Interrupted.
std::string validate(const Room& room, const ValidateOptions& options);

}  // namespace raywalk
