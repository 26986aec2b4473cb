// Text from outside, such as file names and answers of devices, made safe to show.
#pragma once

#include <string>
#include <string_view>

namespace raywalk {

enum class LineBreaks {
  kEscape,  // the text is to be one line
  kKeep     // the text has lines and columns: '\n' and '\t' stay
};

// `text` with escapes for everything that would act on a terminal or mislead a reader: "\n", "\r"
// and "\t"; "\u001b" for other control characters and for those that break lines or change the
// direction of writing (as in JSON, which stays valid); "\xff" for bytes that are not UTF-8. All
// other characters are as they are.
std::string escaped(std::string_view text, LineBreaks breaks = LineBreaks::kEscape);

}  // namespace raywalk
