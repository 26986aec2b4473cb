// Where this program is installed.
#pragma once

#include <filesystem>

namespace raywalk {

// The folder of this program's executable, beside which its other files are; empty where the system
// does not tell.
std::filesystem::path program_folder();

}  // namespace raywalk
