// path: many views, one picture each, or a video.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/parallel.h"
#include "core/command_line/command_options.h"
#include "render/commands/commands.h"
#include "render/commands/view_flags.h"
#include "render/video/video_encoder.h"
#include "render/view/view_video.h"

namespace raywalk::render {
namespace {

constexpr const char* kMovementGroup = "Smooth movement and videos";

const std::map<std::string, Pace> kPaces = {
    {"constant", Pace::kConstant}, {"eased", Pace::kEased}, {"recorded", Pace::kRecorded}};
const std::vector<std::string> kFormats = {"png", "jpg", "webp", "tif"};

struct PathArguments {
  std::string room{};
  std::filesystem::path path{};
  std::filesystem::path out{};
  std::string format = "png";
  std::optional<int> quality{};
  std::filesystem::path video{};
  std::string codec = "h264";
  std::string smooth{};
  SmoothMovement movement{};
  std::optional<int> crf{};
  bool force = false;
  ViewFrame frame{};
  ViewFlags flags{};
  Demand demand{};
  DeviceFlags device{};
  int threads = 0;
  // Whether the flag of this name was given.
  std::function<bool(const char*)> given{};
};

// Throws UsageError for the first of the flags that was given, with the reason why it may not be.
void refuse(const PathArguments& arguments, std::initializer_list<const char*> flags,
            const std::string& reason) {
  for (const char* flag : flags) {
    if (arguments.given(flag)) throw UsageError(std::string(flag) + " " + reason);
  }
}

void require_consistent(const PathArguments& arguments) {
  if (arguments.smooth.empty()) {
    refuse(arguments, {"--seconds", "--speed-m-per-s"},
           "is of a movement between the table's places; give --smooth too");
  }
  if (arguments.video.empty()) {
    refuse(arguments, {"--codec", "--crf"}, "is of a video; give --video too");
    if (arguments.smooth.empty()) {
      refuse(arguments, {"--fps"}, "is of a video or a movement; give --video or --smooth too");
    }
  } else {
    refuse(arguments, {"--out", "--format", "--quality"},
           "is of pictures; leave it out, or --video");
  }
}

PathRequest request_of(const PathArguments& arguments) {
  PathRequest request{.table = arguments.path};
  if (!arguments.smooth.empty()) {
    request.movement = arguments.movement;
    request.movement->pace = kPaces.at(arguments.smooth);
    require_movement(*request.movement);
  }
  return request;
}

void run(const PathArguments& arguments) {
  set_thread_count(arguments.threads);
  use_device(arguments.device);
  viewport_of(arguments.frame);
  view_settings(arguments.flags);
  require_demand(arguments.demand);
  require_consistent(arguments);
  const PathRequest request = request_of(arguments);
  const PictureFormat format = picture_format("view." + arguments.format, arguments.quality);
  const VideoSettings video{.codec = kVideoCodecs.at(arguments.codec),
                            .fps = arguments.movement.fps,
                            .crf = arguments.crf};
  if (!arguments.video.empty()) {
    require_video_settings(video, arguments.video);
    find_ffmpeg();
  }
  const Room room = Room::open(arguments.room);
  const ViewMode mode = chosen_mode(arguments.flags, arguments.demand, room);
  const std::filesystem::path out = arguments.out.empty() ? arguments.path.stem() : arguments.out;
  const std::string summary =
      arguments.video.empty()
          ? write_path(room, mode, arguments.frame, request, format, out, arguments.force)
          : write_video(room, mode, arguments.frame, request, video, arguments.video,
                        arguments.force);
  fmt::print("{}\n", escaped(summary));
}

template <typename Value>
std::vector<std::string> names_of(const std::map<std::string, Value>& values) {
  std::vector<std::string> names;
  names.reserve(values.size());
  for (const auto& [name, value] : values) names.push_back(name);
  return names;
}

void add_movement_flags(CLI::App* command, PathArguments* arguments) {
  command->option_defaults()->group(kMovementGroup);
  command
      ->add_option("--smooth", arguments->smooth,
                   "Move smoothly through the table's places instead of showing them alone: at a "
                   "constant speed, eased (slow at the start and the end), or as recorded (by the "
                   "table's column time, seconds)")
      ->check(one_of(names_of(kPaces)));
  command->add_option("--seconds", arguments->movement.seconds,
                      "How long the movement takes, seconds");
  command->add_option("--speed-m-per-s", arguments->movement.speed_m_per_s,
                      "Its speed, on average, metres per second (default 0.4)");
  command
      ->add_option("--fps", arguments->movement.fps,
                   "Frames per second of the movement and the video, 1 to 240 (default 30)")
      ->check(CLI::Range(1.0, 240.0));
  command->add_option("--video", arguments->video,
                      "Write a video instead of pictures, .mp4 or for ProRes .mov; needs ffmpeg. "
                      "A video that is interrupted is not kept");
  command
      ->add_option("--codec", arguments->codec,
                   "How the video is coded: h264 (default), h265, av1 or prores (422 HQ)")
      ->check(one_of(names_of(kVideoCodecs)));
  command->add_option(
      "--crf", arguments->crf,
      "Quality of the video, lower is better and larger: h264 0 to 51 (default 18), "
      "h265 0 to 51 (default 20), av1 0 to 63 (default 28)");
}

}  // namespace

void add_path(CLI::App* app) {
  CLI::App* command =
      app->add_subcommand("path", "Render many views, one picture each, or a video");
  auto arguments = std::make_shared<PathArguments>();
  arguments->given = [command](const char* flag) { return command->count(flag) > 0; };
  add_room(command, &arguments->room);
  command
      ->add_option("path", arguments->path,
                   "CSV table of views: columns name,x,z and optionally y (metres), yaw,pitch,roll "
                   "(degrees) and time (seconds)")
      ->required();
  command->add_option(
      "-o,--out", arguments->out,
      "Directory for <name>.png, created if it is missing (default: the table's name "
      "without .csv)");
  command->add_option("--format", arguments->format, "Pictures: png (default), jpg, webp or tif")
      ->check(one_of(kFormats));
  add_quality_flag(command, &arguments->quality);
  add_force_flag(
      command, &arguments->force,
      "Replace the views in --out, which were rendered with other settings, or the video");
  add_view_flags(command, &arguments->flags);
  add_demand_flags(command, &arguments->demand);
  add_flat_flags(command, &arguments->frame);
  add_stereo_flags(command, &arguments->frame);
  add_device_flags(command, "auto", &arguments->device);
  add_threads_option(command, &arguments->threads);
  add_movement_flags(command, arguments.get());
  command->footer(
      "Examples:\n  raywalk-render path room.lf path.csv --method two-sided --out views\n"
      "  raywalk-render path room.lf path.csv --stereo ods --out stereo\n"
      "  raywalk-render path room.lf path.csv --smooth eased --seconds 10 --video walk.mp4\n"
      "  raywalk-render path room.lf path.csv --smooth constant --fov-deg 90 --size 1920x1080 "
      "--video flat.mp4\n"
      "An interrupted run to --out is resumed by the same command; a video starts anew.");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace raywalk::render
