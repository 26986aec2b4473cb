#include "render/view/view_path.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/evaluate/measured_settings.h"
#include "core/files/atomic_output.h"
#include "core/files/fingerprint.h"
#include "core/files/output_folder.h"
#include "core/room/room.h"
#include "render/view/view_file.h"
#include "render/view/write_picture.h"

namespace raywalk::render {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kFormatVersion = 1;
constexpr const char* kEnlargement = "enlargement";
constexpr const char* kDistances = "distances";

json settings_of(const Room& room, const ViewMode& mode, const ViewFrame& frame,
                 const PictureFormat& format) {
  json settings{{"format_version", kFormatVersion},
                {"room_sha256", room_fingerprint(room)},
                {kDistances, distances_used(room, mode)},
                {"connection", mode.connection}};
  for (const ViewParameter& parameter : kViewParameters)
    settings[parameter.key] = json_of(parameter, mode.options);
  if (const std::optional<Viewport> viewport = viewport_of(frame)) {
    settings["fov_deg"] = frame.fov_deg;
    settings["size_px"] = fmt::format("{}x{}", viewport->width, viewport->height);
  }
  if (frame.stereo == Stereo::kOds) {
    settings["stereo"] = "ods";
    settings["ipd_mm"] = ipd_mm_of(frame);
  }
  settings["format"] = format.extension;
  if (format.quality) settings["quality"] = *format.quality;
  return settings;
}

json json_of(std::span<const PathView> views) {
  json list = json::array();
  for (const PathView& view : views) {
    const PlanPoint at = view.viewpoint.plan;
    json entry{{"name", view.name}, {"x_m", at.x_m}, {"z_m", at.z_m}};
    if (view.viewpoint.height_m) entry["y_m"] = *view.viewpoint.height_m;
    if (view.yaw_deg != 0.0) entry["yaw_deg"] = view.yaw_deg;
    if (view.pitch_deg != 0.0) entry["pitch_deg"] = view.pitch_deg;
    if (view.roll_deg != 0.0) entry["roll_deg"] = view.roll_deg;
    list.push_back(std::move(entry));
  }
  return list;
}

std::map<std::string, json> by_name(const json& views) {
  std::map<std::string, json> found;
  for (const json& view : views) found[view.at("name").get<std::string>()] = view;
  return found;
}

// Throws Error unless `earlier` has the settings of `now`, so that their pictures may share a
// directory.
void require_same_work(json earlier, json now, const fs::path& record) {
  const std::map<std::string, json> earlier_views = by_name(earlier.at("views"));
  for (const json& view : now.at("views")) {
    const auto found = earlier_views.find(view.at("name").get<std::string>());
    if (found != earlier_views.end() && found->second != view) {
      throw Error(
          fmt::format("{}: '{}' was rendered at another viewpoint; use another --out, or --force",
                      record.string(), found->first));
    }
  }
  for (json* record_json : {&earlier, &now}) {
    record_json->erase("views");
    record_json->erase(kEnlargement);  // follows from the others
    record_json->erase(kDistances);    // room_sha256 stands for them
  }
  std::set<std::string> keys;
  for (const auto& [key, value] : now.items()) keys.insert(key);
  for (const auto& [key, value] : earlier.items()) keys.insert(key);
  for (const std::string& key : keys) {
    if (earlier.value(key, json()) != now.value(key, json())) {
      throw Error(fmt::format(
          "{}: the views there were rendered with another {}; use another --out, or --force",
          record.string(), key == "room_sha256" ? "room" : key));
    }
  }
}

// Compares with the views.json of an earlier run and writes it with the views of both.
void write_record(const fs::path& out, json now, double enlargement) {
  const fs::path record = out / "views.json";
  if (fs::exists(record)) {
    try {
      const json earlier = json::parse(read_file(record));
      require_same_work(earlier, now, record);
      std::map<std::string, json> others = by_name(earlier.at("views"));
      for (const json& view : now.at("views")) others.erase(view.at("name").get<std::string>());
      for (const auto& [name, view] : others) now["views"].push_back(view);
    } catch (const json::exception&) {
      throw Error(record.string() + ": not as raywalk-render path writes it; use another --out");
    }
  }
  now[kEnlargement] = enlargement;
  write_file_atomically(
      record, now.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

fs::path path_picture(const fs::path& out, const PathView& view, const PictureFormat& format) {
  return out / (view.name + format.extension);
}

// Throws Error for existing pictures without views.json: their settings are unknown.
void require_no_strangers(const fs::path& out, std::span<const PathView> views,
                          const PictureFormat& format) {
  if (fs::exists(out / "views.json")) return;
  for (const PathView& view : views) {
    const fs::path picture = path_picture(out, view, format);
    if (fs::exists(picture)) {
      throw Error(picture.string() +
                  " exists and was not made by raywalk-render path; use another --out");
    }
  }
}

// Whether --force may replace a directory of views.
void require_views_only(const fs::path& out) {
  const fs::path record = out / "views.json";
  std::set<std::string> pictures;
  if (fs::exists(record)) {
    try {
      const json earlier = json::parse(read_file(record));
      const auto extension = earlier.at("format").get<std::string>();
      for (const auto& [name, view] : by_name(earlier.at("views"))) {
        pictures.insert(name + extension);
      }
    } catch (const json::exception&) {
      // Unreadable: then no picture is known to be a view, and require_replaceable names the first.
    }
  }
  require_replaceable(
      out, {"a directory of views", "views.json", "\"room_sha256\"",
            [&](const fs::path& relative, bool is_directory) {
              const std::string name = relative.string();
              return !is_directory &&
                     (name == "views.json" || name.front() == '.' || pictures.count(name) > 0);
            }});
}

// The directory in which a replacement of `out` is rendered. What a stopped run left there is kept
// where it has the same settings; `wanted` is the record of this run.
fs::path prepared_replacement(const fs::path& out, const json& wanted) {
  require_views_only(out);
  fs::path partial = out.string() + ".partial";
  require_views_only(partial);
  const fs::path record = partial / "views.json";
  try {
    if (fs::exists(record)) require_same_work(json::parse(read_file(record)), wanted, record);
  } catch (const std::exception&) {  // other settings, or damaged
    fs::remove_all(partial);
  }
  return partial;
}

// Renders the missing ones of the views to `out`; "24 views, 3 of them rendered now".
std::string render_path(const Room& room, const ViewMode& mode, const ViewFrame& frame,
                        std::span<const PathView> views, const PictureFormat& format, json record,
                        const fs::path& out) {
  make_directories(out);
  require_no_strangers(out, views, format);
  const int captured_px = room.panorama().width;
  const int output_px = mode.options.width > 0 ? mode.options.width : captured_px;
  const double enlargement = enlargement_of(frame, output_px, captured_px);
  write_record(out, std::move(record), enlargement);

  std::vector<PlacedFrame> frames;
  std::vector<fs::path> pictures;
  for (const PathView& view : views) {
    const fs::path picture = path_picture(out, view, format);
    if (fs::exists(picture)) continue;
    frames.push_back({view.viewpoint, turned_as(view, frame)});
    pictures.push_back(picture);
  }
  std::size_t done = views.size() - frames.size();
  Progress progress("rendering", static_cast<std::int64_t>(views.size()), "views");
  progress.advance(static_cast<std::int64_t>(done));
  const auto use = [&](std::size_t i, const cv::Mat& image) {
    write_picture(pictures[i], image, format,
                  describe_view(room, mode, frames[i].viewpoint, frames[i].frame));
    progress.advance();
    ++done;
  };
  try {
    render_frames(room, mode.options, frames, use);
  } catch (const Interrupted&) {
    throw Interrupted(fmt::format("interrupted after {} of {} views; the same command resumes",
                                  done, views.size()));
  }
  const std::string enlarged = enlargement_text(enlargement, captured_px);
  return fmt::format("{} views, {} of them rendered now{}", views.size(), frames.size(),
                     enlarged.empty() ? "" : ", " + enlarged);
}

}  // namespace

void require_renderable(const Room& room, const ViewMode& mode, const ViewFrame& frame,
                        const fs::path& source, std::span<const PathView> views) {
  for (const PathView& view : views) {
    try {
      viewport_of(turned_as(view, frame));
      require_viewpoint(view.viewpoint, mode.options.method);
    } catch (const UsageError& e) {
      throw Error(fmt::format("{}: view '{}': {}", source.string(), view.name, e.what()));
    }
  }
  require_inside(room, connection_rule(mode), source, views,
                 frame.stereo == Stereo::kOds ? 1e-3 * ipd_mm_of(frame) : 0.0);
}

std::vector<PathView> views_of(const PathRequest& request, const Room& room, const ViewMode& mode,
                               const ViewFrame& frame) {
  std::vector<PathView> views = read_path(request.table);
  if (request.movement) views = frames_of(views, *request.movement, request.table);
  require_renderable(room, mode, frame, request.table, views);
  return views;
}

std::string write_path(const Room& room, const ViewMode& mode, const ViewFrame& frame,
                       const PathRequest& request, const PictureFormat& format, const fs::path& out,
                       bool replace) {
  const std::vector<PathView> views = views_of(request, room, mode, frame);
  const fs::path target = without_trailing_slash(out);
  json record = settings_of(room, mode, frame, format);
  record["views"] = json_of(views);
  const bool replaces = replace && fs::exists(fs::symlink_status(target));
  const fs::path directory = replaces ? prepared_replacement(target, record) : target;
  const std::string rendered =
      render_path(room, mode, frame, views, format, std::move(record), directory);
  if (replaces) move_into_place(directory, target);
  return fmt::format("{}: {}, {}, {} at k = {:g} degrees ({}), distances {}", out.string(),
                     rendered, method_name(mode.options.method), mode.connection,
                     mode.options.k_deg, mode.k_source, distances_used(room, mode));
}

}  // namespace raywalk::render
