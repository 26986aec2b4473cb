// lens, stitch, mask, poses, rectify: one step each.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "calibrate/base/frame_masks.h"
#include "calibrate/chain/calibration_report.h"
#include "calibrate/commands/commands.h"
#include "calibrate/commands/step_options.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/parallel.h"
#include "core/command_line/command_options.h"

namespace raywalk::calibrate {
namespace {

using Arguments = std::shared_ptr<StepArguments>;

Arguments add_step(CLI::App* command) {
  auto arguments = std::make_shared<StepArguments>();
  add_input(command, arguments.get());
  return arguments;
}

void print_result(const Calibration& calibration, CalibrationStep step) {
  const nlohmann::ordered_json document = step_document(calibration, step);
  fmt::print("{}: {}\n{}: done in {:.1f} s; see {}\n", step_name(step),
             step_numbers(step, document), step_name(step), calibration.seconds(step),
             escaped((calibration.out() / "index.html").string()));
}

void run_and_print(Calibration* calibration, CalibrationStep step) {
  run_reported(calibration, step);
  write_calibration_until(*calibration, step);
  print_result(*calibration, step);
}

Calibration run_step(const StepArguments& arguments, CalibrationStep step) {
  set_thread_count(arguments.threads);
  Calibration calibration(options_of(arguments));
  run_and_print(&calibration, step);
  return calibration;
}

void run_stitch(const StepArguments& arguments) {
  set_thread_count(arguments.threads);
  Calibration calibration(options_of(arguments));
  if (!calibration.has(CalibrationStep::kStitch)) {
    fmt::print("stitch: the frames are panoramas already; nothing to do\n");
    return;
  }
  // A lens file on the command line replaces the step lens.
  if (calibration.options().lens_file) calibration.run(CalibrationStep::kLens);
  run_and_print(&calibration, CalibrationStep::kStitch);
}

void run_mask(const StepArguments& arguments) {
  const MaskOptions& mask = arguments.options.mask;
  const bool defined = mask.cone_deg != 0.0 || !arguments.mask_picture.empty() || mask.automatic;
  if (!defined && !any_masks(read_capture_set(options_of(arguments).input))) {
    throw UsageError("no mask is defined; give --cone-deg, --mask-picture or --auto-mask");
  }
  run_step(arguments, CalibrationStep::kMask);
}

void run_poses(const StepArguments& arguments) {
  const Calibration calibration = run_step(arguments, CalibrationStep::kPoses);
  const nlohmann::ordered_json poses = step_document(calibration, CalibrationStep::kPoses);
  if (poses.at("trustworthy").get<bool>()) return;
  const auto warnings = poses.at("warnings").get<std::vector<std::string>>();
  throw Error(
      fmt::format("the poses are not trustworthy: {}; index.html and poses.json are kept in {}",
                  warnings.empty() ? "its own checks contradict it" : warnings.front(),
                  calibration.out().string()));
}

void run_rectify(const StepArguments& arguments) {
  const Calibration calibration = run_step(arguments, CalibrationStep::kRectify);
  const nlohmann::ordered_json rectified = step_document(calibration, CalibrationStep::kRectify);
  fmt::print("{}\n", escaped(rectified.at("next_command").get<std::string>()));
}

}  // namespace

void add_lens(CLI::App* app) {
  CLI::App* command = app->add_subcommand("lens", "Calibrate the lenses of a dual-fisheye camera");
  const Arguments arguments = add_step(command);
  add_lens_options(command, arguments.get());
  command
      ->add_option("--ignore-below-deg", arguments->options.lens.ignore_below_deg,
                   "Half angle of an ignored cone below the camera, degrees")
      ->check(CLI::Range(0.0, 89.0));
  command->footer("Example:\n  raywalk-calibrate lens hall --lens-start theta-like");
  command->callback([arguments] { run_step(*arguments, CalibrationStep::kLens); });
}

void add_stitch(CLI::App* app) {
  CLI::App* command = app->add_subcommand("stitch", "Stitch dual-fisheye frames to panoramas");
  const Arguments arguments = add_step(command);
  takes_config(command->add_option("--lens", arguments->lens_file,
                                   "Lens file to use (default: result of the step lens)"),
               ConfigKind::kLens);
  add_stitch_options(command, arguments.get());
  command->footer("Example:\n  raywalk-calibrate stitch hall");
  add_resumption(command);
  command->callback([arguments] { run_stitch(*arguments); });
}

void add_mask(CLI::App* app) {
  CLI::App* command = app->add_subcommand("mask", "Mask the dolly or operator below the camera");
  const Arguments arguments = add_step(command);
  add_mask_options(command, arguments.get());
  command->footer(
      "Example:\n  raywalk-calibrate mask hall --cone-deg 25\n"
      "  raywalk-calibrate mask hall --auto-mask\n"
      "Masks that poses.csv names for its frames (column mask) are joined with this one by every\n"
      "step.");
  command->callback([arguments] { run_mask(*arguments); });
}

void add_poses(CLI::App* app) {
  CLI::App* command =
      app->add_subcommand("poses", "Solve the poses of the panoramas and the lines of the rail");
  const Arguments arguments = add_step(command);
  add_poses_options(command, arguments.get());
  command->footer(
      "Example:\n  raywalk-calibrate poses hall --keyframes-mm 100\n"
      "Frames of a gt.csv beside poses.csv are solved with the stations, all of them.");
  add_resumption(command);
  command->callback([arguments] { run_poses(*arguments); });
}

void add_rectify(CLI::App* app) {
  CLI::App* command = app->add_subcommand(
      "rectify",
      "List the frames with their poses in the grid, those of fisheye pictures made anew");
  const Arguments arguments = add_step(command);
  command->add_option("--poses", arguments->pose_table,
                      "Poses to use: a table file,x,y,z,yaw,pitch,roll in metres and degrees "
                      "(default: result of the step poses)");
  command->footer(
      "Example:\n  raywalk-calibrate rectify hall\n"
      "  raywalk-build-lf pack --frames hall/calibration/poses.csv --out hall.lf\n"
      "Masks of frames are turned with them. Frames of a gt.csv beside poses.csv are listed in "
      "the\n"
      "gt.csv of the result.");
  command->callback([arguments] { run_rectify(*arguments); });
}

}  // namespace raywalk::calibrate
