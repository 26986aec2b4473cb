// Frame files that a killed import stored but did not record in the session.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/session/session_reader.h"

namespace raywalk::capture {

// The files in a session's frames/ that no row of its database names.
class UnnamedFrames {
 public:
  explicit UnnamedFrames(SessionReader* reader);

  // A file of this station with exactly these bytes, relative to the session's directory, to be
  // reused as its name is taken. It and its directory are synced on return. Throws Error if that
  // fails.
  std::optional<std::string> find(const std::string& station, const std::string& bytes) const;

 private:
  std::filesystem::path session_directory_;
  std::vector<std::string> files_;  // ascending
};

}  // namespace raywalk::capture
