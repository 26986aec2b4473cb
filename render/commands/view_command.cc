// view: one picture.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>

#include "core/base/escaped.h"
#include "core/base/parallel.h"
#include "core/command_line/command_options.h"
#include "core/files/output_folder.h"
#include "render/commands/commands.h"
#include "render/commands/view_flags.h"
#include "render/view/point_argument.h"
#include "render/view/view_file.h"

namespace raywalk::render {
namespace {

struct ViewArguments {
  std::string room{};
  std::string at{};
  std::string out = "view.png";
  std::optional<int> quality{};
  ViewFrame frame{};
  ViewFlags flags{};
  Demand demand{};
  DeviceFlags device{};
  int threads = 0;
};

void run(const ViewArguments& arguments) {
  set_thread_count(arguments.threads);
  use_device(arguments.device);
  const Viewpoint viewpoint = viewpoint_from_text(arguments.at);
  view_settings(arguments.flags);  // reports contradictions before any work
  require_demand(arguments.demand);
  viewport_of(arguments.frame);
  const PictureFormat format = picture_format(arguments.out, arguments.quality);
  require_writable_view(arguments.out);
  const Room room = Room::open(arguments.room);
  const ViewMode mode = chosen_mode(arguments.flags, arguments.demand, room);
  fmt::print("{}\n",
             escaped(write_view(room, mode, viewpoint, arguments.frame, arguments.out, format)));
}

}  // namespace

void add_view(CLI::App* app) {
  CLI::App* command = app->add_subcommand("view", "Render one view as a picture");
  auto arguments = std::make_shared<ViewArguments>();
  add_room(command, &arguments->room);
  add_point_option(
      command, "--at", &arguments->at,
      "Viewpoint X,Z or X,Y,Z in metres, in the frame of poses.csv; without Y the eye is "
      "at the height of the lines around",
      PointKind::kPlanOrSpace)
      ->required();
  command->add_option("-o,--out", arguments->out,
                      "Picture to write, .png, .jpg, .webp or .tif (default: view.png)");
  add_quality_flag(command, &arguments->quality);
  add_view_flags(command, &arguments->flags);
  add_demand_flags(command, &arguments->demand);
  add_device_flags(command, "auto", &arguments->device);
  add_threads_option(command, &arguments->threads);
  command->option_defaults()->group(kDirectionGroup);
  command->add_option("--yaw-deg", arguments->frame.yaw_deg, "Turn to the right, degrees");
  command->add_option("--pitch-deg", arguments->frame.pitch_deg, "Look up, degrees");
  command->add_option("--roll-deg", arguments->frame.roll_deg,
                      "Tilt the camera clockwise, degrees");
  add_flat_flags(command, &arguments->frame);
  add_stereo_flags(command, &arguments->frame);
  command->footer(
      "Examples:\n  raywalk-render view room.lf --at -0.1,0.25 -o view.png\n"
      "  raywalk-render view room.lf --at -0.1,0.25 --yaw-deg 40 --pitch-deg -10 --fov-deg 90 "
      "--size 1440x1600 --out eye.png\n"
      "  raywalk-render view room.lf --at -0.1,0.05,0.25 --method two-sided --stereo ods -o "
      "ods.png\n"
      "  raywalk-render view room.lf --at -0.1,0.25 --quality 90 -o view.jpg\n"
      "Pictures say what they show: Photo Sphere metadata in panoramas, the focal length in flat "
      "ones.");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace raywalk::render
