// all: the whole chain.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "calibrate/chain/run_all.h"
#include "calibrate/commands/commands.h"
#include "calibrate/commands/step_options.h"
#include "core/base/parallel.h"
#include "core/command_line/command_options.h"

namespace raywalk::calibrate {
namespace {

struct ChainArguments {
  StepArguments steps{};
  ChainOptions chain{};
  std::string redo{};
};

std::vector<std::string> step_names() {
  std::vector<std::string> names;
  names.reserve(std::size(kCalibrationSteps));
  for (const CalibrationStep step : kCalibrationSteps) names.push_back(step_name(step));
  return names;
}

std::optional<CalibrationStep> step_named(const std::string& name) {
  for (const CalibrationStep step : kCalibrationSteps) {
    if (step_name(step) == name) return step;
  }
  return std::nullopt;
}

void run(const ChainArguments& arguments) {
  set_thread_count(arguments.steps.threads);
  Calibration calibration(options_of(arguments.steps));
  ChainOptions chain = arguments.chain;
  chain.redo = step_named(arguments.redo);
  run_all(&calibration, chain, std::cout);
}

}  // namespace

void add_all(CLI::App* app) {
  CLI::App* command = app->add_subcommand("all", "Run all calibration steps that are not done yet");
  auto arguments = std::make_shared<ChainArguments>();
  StepArguments* steps = &arguments->steps;
  add_input(command, steps);
  add_lens_options(command, steps);
  add_stitch_options(command, steps);
  add_mask_options(command, steps);
  add_poses_options(command, steps);
  command->option_defaults()->group("Options");
  command
      ->add_option("--redo", arguments->redo,
                   "Run this step again, and the steps that depend on it")
      ->check(one_of(step_names()));
  command
      ->add_option("--compare-keyframes", arguments->chain.compare_keyframes_mm,
                   "Also solve with these keyframe spacings, mm, and report time and accuracy")
      ->delimiter(',')
      ->check(CLI::Range(0.0, 1e6));
  command->footer(
      "Example:\n  raywalk-calibrate all hall --lens-start theta-like "
      "--cone-deg 25\n"
      "  raywalk-build-lf pack --frames hall/calibration/poses.csv --out hall.lf\n"
      "A column mask of poses.csv is honoured by every step. Frames of a gt.csv beside poses.csv "
      "are\n"
      "posed and rectified too, for raywalk-render validate, but have no part in the lines.\n"
      "Steps whose inputs and options have not changed are skipped. The exit code is 1 on an "
      "error\n"
      "or if the result is not trustworthy.");
  add_resumption(command);
  command->callback([arguments] { run(*arguments); });
}

}  // namespace raywalk::calibrate
