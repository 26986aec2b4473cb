// Text from outside, such as file names and answers of devices, made safe to show.
#pragma once

#include <string>
#include <string_view>

namespace raywalk {

// `text` on one line, with escapes for everything that would act on a terminal or mislead a reader:
// "\n", "\r" and "\t"; "\u001b" for other control characters and for those that break lines or
// change the direction of writing; "\xff" for bytes that are not UTF-8. All other characters are as
// they are.
std::string escaped(std::string_view text);

// A file's name as a word of a shell's command, for commands that are printed to be typed: in
// single quotes if it has characters that mean something to a shell.
std::string shell_word(std::string_view name);

}  // namespace raywalk
