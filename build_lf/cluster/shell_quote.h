// Words of a shell's command line.
#pragma once

#include <string>
#include <string_view>

namespace raywalk::build_lf {

// `word` such that a POSIX shell takes it as one word, unchanged: as it is where it has letters,
// digits and harmless signs only, else in single quotes.
std::string shell_quoted(std::string_view word);

}  // namespace raywalk::build_lf
