// Packs a captured grid into a room: `raywalk-build-lf pack`.
#pragma once

#include <filesystem>
#include <string>

#include "build_lf/pack/pack_plan.h"
#include "build_lf/pack/work_part.h"
#include "core/room/room.h"

namespace raywalk::build_lf {

// Creates the room `options.out`, which appears only when complete. A stopped run (Interrupted,
// disk full, an image that cannot be decoded) keeps its finished volumes in `<out>.partial`, and
// the same command resumes it, also what parts left there. Unchanged volumes of a room that is
// replaced are taken over. Throws Error as plan_pack and RoomFolder do, and for too little disk
// space, an image that cannot be decoded and output that cannot be written.
void pack_room(const PackOptions& options);

// Packs the lines of one part into `<out>.partial`, which parts on any machines share: every
// count-th line, as those next to each other are of one length. What is packed is not packed again.
// Returns a sentence for the terminal. Throws Error as pack_room does.
std::string pack_part(const PackOptions& options, WorkPart part);

// Whether the room there is complete and made from the plan's inputs. Throws Error.
bool is_packed_from(const std::filesystem::path& room, const PackPlan& plan);

// The manifest of a room whose volumes are complete; reads the distances to record their checksums.
// Throws Error if a volume cannot be read.
RoomManifest manifest_of_volumes(const std::filesystem::path& room, PanoramaSize panorama,
                                 const Grid& grid);

// RoomManifest::rays_sha256 of a line, from the checksums stored in its volume.
std::string checksum_of_line(const std::filesystem::path& volume);

}  // namespace raywalk::build_lf
