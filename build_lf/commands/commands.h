// The commands of raywalk-build-lf. Each function adds one command with its options, an example and
// the callback that runs it.
#pragma once

#include <optional>
#include <string>

#include "build_lf/pack/work_part.h"

namespace CLI {
class App;
}

namespace raywalk::build_lf {

// Making rooms.
void add_all(CLI::App* app);
void add_pack(CLI::App* app);
void add_repack(CLI::App* app);
void add_refine(CLI::App* app);
// What is estimated for them.
void add_depth(CLI::App* app);
void add_distances(CLI::App* app);
void add_gains(CLI::App* app);
// Looking at them, and what comes after.
void add_info(CLI::App* app);
void add_verify(CLI::App* app);
void add_require(CLI::App* app);
void add_export(CLI::App* app);

// --part I/N; `pieces` says in words what is divided.
void add_part_option(CLI::App* app, std::optional<WorkPart>* part, const std::string& pieces);

}  // namespace raywalk::build_lf
