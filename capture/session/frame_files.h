// The folder of a session's pictures, which appear complete, survive power loss and are never
// overwritten (write_new_file of core/files/atomic_output.h).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace raywalk::capture {

inline constexpr char kFramesDirectory[] = "frames";  // in the session's

// Whether a file in frames/ has a temporary name.
bool is_temporary_frame(const std::filesystem::path& file);

// Removes the temporary files of a killed run. Throws Error naming one that cannot be removed.
void remove_temporary_frames(const std::filesystem::path& session_directory);

// Names of all files in frames/ of a session, relative to the session, sorted, with temporary ones.
// Empty if the directory is missing. Throws Error if it cannot be read.
std::vector<std::string> list_frames(const std::filesystem::path& session_directory);

}  // namespace raywalk::capture
