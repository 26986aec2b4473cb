// The views and connection errors measured so far, kept in `<report>/validation.partial` while a
// validation runs, so that a stopped run is resumed by the same command. Each is stored under a key
// of everything it depends on: what was measured from other inputs is never found.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/evaluate/metrics/silhouettes.h"
#include "core/evaluate/validation/comparison_pictures.h"
#include "core/evaluate/validation/quarter_scores.h"
#include "core/evaluate/validation/truth_views.h"
#include "core/evaluate/validation/view_scores.h"
#include "core/files/file_lock.h"
#include "core/view/renderer.h"

namespace raywalk {

// The result of one truth in one mode.
struct MeasuredView {
  ViewReport report{};
  ViewScores scores{};
  SilhouetteScores silhouettes{};  // not measured where the truth has no distances
  std::vector<QuarterScore> quarters{};
  std::optional<ViewComparison> pictures{};  // where the report shows the view
};

class ValidationPartial {
 public:
  // Creates or reuses the directory and locks it. Throws Error if another run holds the lock or the
  // directory cannot be written.
  ValidationPartial(const std::filesystem::path& report, const Room& room);
  // For another room of the same report: shares the directory and its lock.
  ValidationPartial(const ValidationPartial& partial, const Room& room);
  // Removes the directory if nothing is kept in it.
  ~ValidationPartial();
  ValidationPartial(const ValidationPartial&) = delete;
  ValidationPartial& operator=(const ValidationPartial&) = delete;

  // The key of a truth: the fingerprint of the room and its distances, the viewpoint, the content
  // of the truth's files, and whether the report shows it. Throws Error where a file cannot be
  // read.
  std::string key_of(const TruthView& truth, bool shown) const;
  // The key of a view of that truth.
  static std::string key_of(const std::string& truth_key, const ViewOptions& options);

  // A view that was kept; none if it is missing or damaged.
  std::optional<MeasuredView> find(const std::string& key) const;
  // Stores a view, atomically. Throws Error if it cannot be written.
  void keep(const std::string& key, const MeasuredView& view) const;

  // The existing directory in which connection errors of this room are kept, as in a room
  // (connect_error_file.h).
  const std::filesystem::path& connection_errors() const { return connection_errors_; }

  // Removes the directory and everything in it.
  void complete();

 private:
  std::filesystem::path file_of(const std::string& key) const;
  bool is_empty() const;

  std::filesystem::path directory_;
  std::shared_ptr<FileLock> lock_;
  std::string room_fingerprint_;
  std::filesystem::path connection_errors_;
};

}  // namespace raywalk
