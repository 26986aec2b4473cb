// Frames that an import which was killed had stored, and had not come to record.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/session/session_reader.h"

namespace raywalk::capture {

// The files in a session's frames/ that no row names.
class UnnamedFrames {
 public:
  explicit UnnamedFrames(SessionReader* reader);

  // One of this station with just these bytes, relative to the session; safe against power loss
  // when it returns. Storing the picture once more would find its name taken.
  std::optional<std::string> find(const std::string& station, const std::string& bytes) const;

 private:
  std::filesystem::path session_directory_;
  std::vector<std::string> files_;  // ascending
};

}  // namespace raywalk::capture
