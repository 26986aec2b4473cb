// Finds other programs as a shell does.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace raywalk {

// The first executable file of this name in the folders of PATH, as an absolute path; none if there
// is none.
std::optional<std::filesystem::path> find_program(const std::string& name);

}  // namespace raywalk
