// Volumes of a room that a new pack of nearly the same frames takes over instead of writing them
// again: `pack --force` after one line was captured again reads that line alone.
//
// A room says what each of its volumes was made from in inputs.json. A volume depends on nothing
// but its line: frames, positions, attitudes and masks, or distance maps.
#pragma once

#include <filesystem>
#include <string>

#include "build_lf/pack/pack_plan.h"
#include "build_lf/pack/work_part.h"

namespace raywalk::build_lf {

// Where a room keeps them.
std::filesystem::path line_inputs_path(const std::filesystem::path& room);

// Of a line of the plan. Throws Error if a file cannot be read any more, and Interrupted.
LineInputs line_inputs(const PackPlan& plan, std::size_t line);

// Writes inputs.json of a room that is complete but for its manifest. Throws Error.
void write_line_inputs(const std::filesystem::path& room, const PackPlan& plan);
// Whether the room there is complete and made from the plan's inputs. Throws Error.
bool is_packed_from(const std::filesystem::path& room, const PackPlan& plan);

// How many volumes were taken over.
struct ReusedVolumes {
  std::size_t lines = 0;
  std::size_t distances = 0;
};

// Puts into `room` those volumes of `lines`, indices into the plan's, that it lacks and the room
// `earlier` has of the same inputs: by
// hard links, or copies on file systems without them. What is wrong with `earlier` only means that
// nothing is taken over; a volume that is not as its manifest says is left. Throws Error where
// `room` cannot be written, and Interrupted.
ReusedVolumes reuse_volumes(const std::filesystem::path& earlier, const PackPlan& plan,
                            IndexRange lines, const std::filesystem::path& room);

// What was measured on a room and is lost when it is replaced, for messages: "the estimated
// distances, the gains". Empty: nothing.
std::string measurements_of(const std::filesystem::path& room);

}  // namespace raywalk::build_lf
