// Texts that shells show beside what they complete.
#pragma once

#include <string>

namespace raywalk {

// The beginning of a description, up to what explains it: "Threads to use" of "Threads to use; 0 =
// all cores".
std::string short_description(const std::string& description);

}  // namespace raywalk
