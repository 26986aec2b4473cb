// Flags of every program that print what is installed beside it: its manual page and the completion
// of bash. The help does not show them.
#pragma once

namespace CLI {
class App;
}

namespace raywalk {

// Adds --man and --completion bash to the program. Where one is given, parsing ends as for
// --version, with the text in its place. The program has to be complete when it is parsed.
void add_reference_flags(CLI::App* app);

}  // namespace raywalk
