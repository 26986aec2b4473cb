// Names of unfinished outputs, which are renamed when they are complete.
#pragma once

#include <filesystem>

namespace raywalk {

// A path that does not exist yet, beside the target and with its extension (encoders use it), for a
// file or a directory: ".<stem>.<system>-<process>.<n>.partial<extension>". The dot hides it from
// listings; process id and counter make it unique. The first time in a directory,
// remove_abandoned_temporaries is called for it.
std::filesystem::path temporary_beside(const std::filesystem::path& target);

// Removes the unfinished outputs in a directory whose process was killed: those of processes of
// this system that are no longer running, and those of another system (another computer or
// container on a shared disk, or this one before it was restarted) once they are a day old. What
// cannot be removed stays.
void remove_abandoned_temporaries(const std::filesystem::path& directory);

}  // namespace raywalk
