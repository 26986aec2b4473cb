#include "calibrate/commands/step_options.h"

#include <CLI/CLI.hpp>

#include "core/command_line/command_options.h"
#include "core/files/shipped_configs.h"

namespace raywalk::calibrate {

void add_input(CLI::App* command, StepArguments* arguments) {
  command
      ->add_option(
          "input", arguments->input,
          "Capture session, or folder with poses.csv (file,x,y,z in metres, "
          "[yaw,pitch,roll],[mask],[line]) and perhaps gt.csv (held-out frames, same columns)")
      ->required();
  command->add_option("-o,--out", arguments->out,
                      "Directory of the calibration (default: INPUT/calibration)");
  command
      ->add_option("--exposure", arguments->options.input.exposure,
                   "Number of the exposure of a session's bracket, from 0")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--partial", arguments->options.input.partial,
                    "Accept a session with stations not captured yet");
  command->add_flag("--dual-fisheye", arguments->options.input.dual_fisheye,
                    "The frames of poses.csv are dual-fisheye pictures");
  add_line_tolerance_options(command, &arguments->options.input.tolerance);
  add_threads_option(command, &arguments->threads);
}

void add_lens_options(CLI::App* command, StepArguments* arguments) {
  LensOptions* lens = &arguments->options.lens;
  command->option_defaults()->group("Lenses");
  takes_config(command->add_option("--lens-start", arguments->lens_start,
                                   "Lens file with starting values, or the name of one in "
                                   "configs/lenses, as theta-like"),
               ConfigKind::kLens);
  takes_config(command->add_option("--lens", arguments->lens_file,
                                   "Calibrated lens file, used instead of the fit"),
               ConfigKind::kLens)
      ->excludes("--lens-start");
  command->add_option("--pairs", lens->pairs, "Stations to fit the lenses to")
      ->check(CLI::Range(6, 10000))
      ->capture_default_str();
}

void add_stitch_options(CLI::App* command, StepArguments* arguments) {
  StitchOptions* stitch = &arguments->options.stitch;
  command->option_defaults()->group("Panoramas");
  command
      ->add_option("--width", stitch->width,
                   "Width of the panoramas in pixels (default: by the lenses' resolution)")
      ->check(CLI::Range(32, 32768));
  command->add_option("--blend", arguments->blend, "Blending of the lenses at the seam")
      ->check(one_of({"multi-band", "feather"}))
      ->capture_default_str();
  command->add_option("--blend-deg", stitch->blend_deg, "Width of the blend, degrees")
      ->check(CLI::Range(0.01, 30.0))
      ->capture_default_str();
  command
      ->add_option("--seam-distance-m", stitch->seam_distance_m,
                   "Distance at which the lenses agree at the seam (default: infinity)")
      ->check(CLI::PositiveNumber);
  command->add_flag("--no-balance", arguments->no_balance,
                    "Do not make the light of both lenses equal");
}

void add_mask_options(CLI::App* command, StepArguments* arguments) {
  MaskOptions* mask = &arguments->options.mask;
  command->option_defaults()->group("Masks");
  command
      ->add_option("--cone-deg", mask->cone_deg,
                   "Half angle of a masked cone below the camera, degrees")
      ->check(CLI::Range(0.0, 89.0));
  command->add_option("--mask-picture", arguments->mask_picture,
                      "Grey panorama, black where frames are masked");
  command->add_flag("--auto-mask", mask->automatic, "Detect and mask what moves with the camera");
}

void add_poses_options(CLI::App* command, StepArguments* arguments) {
  PosesOptions* poses = &arguments->options.poses;
  command->option_defaults()->group("Poses");
  command
      ->add_option("--keyframes-mm", poses->keyframes_mm,
                   "Largest distance between solved stations; 0 solves every station")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command
      ->add_option("--face-px", poses->face_px,
                   "Side of the flat faces that features are found in (default: by the "
                   "panoramas' resolution)")
      ->check(CLI::Range(64, 4096));
  command->add_option(
      "--work", arguments->work,
      "Directory to keep COLMAP's files in, best on a local disk (default: OUT/colmap)");
}

CalibrationOptions options_of(const StepArguments& arguments) {
  CalibrationOptions options = arguments.options;
  options.input.directory = arguments.input;
  options.out = arguments.out;
  options.lens.start = named_config(arguments.lens_start, ConfigKind::kLens, "--lens-start");
  if (!arguments.lens_file.empty()) {
    options.lens_file = named_config(arguments.lens_file, ConfigKind::kLens, "--lens");
  }
  options.stitch.blend =
      arguments.blend == "feather" ? BlendMethod::kFeather : BlendMethod::kMultiBand;
  options.stitch.balance = !arguments.no_balance;
  if (!arguments.mask_picture.empty()) options.mask.picture = arguments.mask_picture;
  options.poses.work = arguments.work;
  if (!arguments.pose_table.empty()) options.pose_table = arguments.pose_table;
  return options;
}

}  // namespace raywalk::calibrate
