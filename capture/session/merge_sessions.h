// Sessions of some lines each, of one plan, become one session of the whole plan: lines captured on
// several days or by several rigs, or captured again later.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/base/clock.h"

namespace raywalk::capture {

struct MergeOptions {
  std::vector<std::filesystem::path> sessions{};  // at least one; they stay as they are
  std::filesystem::path out{};                    // the session to create
  bool replace = false;  // of a line in several sessions, the one captured last is taken
  bool partial = false;  // accept lines that no session has, and unfinished ones
};

// Creates the session `options.out`, which appears only when complete. Its frames are hard links to
// those of the parts, or copies where the file system has none. A session contributes the lines of
// which it has captured at least one station. Attempts and journals of these lines come with their
// times, events of all sessions with the name of theirs before the text; the event "merged" of a
// line says which session it came from.
//
// A stopped merge (Interrupted, disk full) leaves `<out>.partial`, and the same call goes on there.
//
// Returns one line that sums up the session. Throws Error: a session as SessionReader and
// require_no_faults do; sessions of different cameras, modes, picture sizes or plans; a line in
// several of them without `replace`; lines missing or unfinished without `partial`; `out` exists or
// cannot be written.
std::string merge_sessions(const MergeOptions& options, Clock* clock);

}  // namespace raywalk::capture
