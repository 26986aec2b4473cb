#include "build_lf/require/thin_room.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <span>

#include "build_lf/pack/derived_volumes.h"
#include "build_lf/pack/pack_room.h"
#include "build_lf/pack/partial_room.h"
#include "build_lf/require/held_out.h"
#include "core/base/pick_evenly.h"
#include "core/base/progress.h"
#include "core/evaluate/metrics.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/output_folder.h"
#include "core/room/distance_maps.h"
#include "core/room/gain_fields.h"
#include "core/room/kept_stations.h"
#include "core/room/room.h"
#include "core/view/renderer.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxViews = 48;

// Over everything that determines the result.
std::string fingerprint_of(const Room& room, const KeptStations& kept, int distance_width) {
  return sha256_hex(fmt::format("{}{} {}", room_fingerprint(room), kept, distance_width));
}

}  // namespace

void write_thinned_room(const Room& room, const KeptStations& kept, int distance_width,
                        const fs::path& out, bool replace) {
  PartialRoom partial(out, fingerprint_of(room, kept, distance_width), replace);
  const fs::path& directory = partial.directory();
  const Room part = room.subset(kept);
  Progress progress("thinning", images_of(part), "images");
  for (int i = 0; i < static_cast<int>(kept.size()); ++i) {
    const RayForm& form = part.volume(i).form();
    write_derived_rays(room, part, i, form, directory, &progress);
    if (room.manifest().distances == DistanceKind::kNone) continue;
    write_derived_maps(part.distances(i), part.grid().lines[static_cast<size_t>(i)],
                       room.manifest().distances, distance_width, form.compressed(), directory,
                       &progress);
  }
  RoomManifest manifest = manifest_of_volumes(directory, part.panorama(), part.grid());
  if (!part.gains().empty()) {
    write_gain_fields(gains_path(directory), part.grid(), part.gains());
    manifest.gains = true;
  }
  write_file_atomically(manifest_path(directory), manifest_to_json(manifest));
  Room::open(directory);  // checks that the result can be opened
  partial.complete();
}

ThinnedFacts thinned_facts(const Room& room, const KeptStations& kept, const fs::path& out) {
  const Room thinned = Room::open(out);
  ThinnedFacts facts{.room = out.string(), .bytes = bytes_in(out)};
  for (size_t line = 0; line < kept.size(); ++line) {
    facts.stations += static_cast<int>(kept[line].size());
    facts.distance_maps += thinned.distances(static_cast<int>(line)).maps();
  }
  const std::vector<HeldOutStation> dropped =
      stations_with_views(room.grid(), stations_except(room.grid(), kept));
  const std::vector<int> views = pick_evenly(static_cast<int>(dropped.size()), kMaxViews);
  facts.views = static_cast<int>(views.size());
  facts.psnr_db = facts.worst_psnr_db = kMaxPsnrDb;
  if (views.empty()) return facts;
  facts.psnr_db = 0.0;
  Progress progress("re-creating", std::ssize(views), "stations");
  Renderer renderer(thinned, {.gains = false});
  for (const int i : views) {
    const TrueView captured = true_view_of(room, dropped[static_cast<size_t>(i)]);
    const cv::Mat view = renderer.render({captured.viewpoint, captured.height_m}).image;
    const double db = psnr_of_view(view, captured);
    facts.psnr_db += db / static_cast<double>(views.size());
    facts.worst_psnr_db = std::min(facts.worst_psnr_db, db);
    progress.advance();
  }
  return facts;
}

}  // namespace raywalk::build_lf
