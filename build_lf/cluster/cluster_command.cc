#include "build_lf/cluster/cluster_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "build_lf/cluster/cluster_folder.h"
#include "build_lf/cluster/cluster_plan.h"
#include "build_lf/pack_plan.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/command_line/command_options.h"
#include "core/files/shipped_configs.h"

namespace raywalk::build_lf {
namespace {

struct Arguments {
  ClusterOptions options{};
  LineToleranceArguments lines{};
  std::string rates;
  std::vector<std::string> flags;
};

// "depth=--width 512"
void add_flags(const std::string& text, std::map<std::string, std::string>* flags) {
  const size_t equals = text.find('=');
  if (equals == std::string::npos) {
    throw UsageError("--add: give COMMAND=FLAGS, not " + excerpt(text));
  }
  std::string& of_command = (*flags)[text.substr(0, equals)];
  of_command += (of_command.empty() ? "" : " ") + text.substr(equals + 1);
}

void add_inputs(CLI::App* command, ClusterOptions* options) {
  command->add_option("--frames", options->frames, "Frame list, as pack reads it")->required();
  command->add_option("-o,--out", options->out, "Folder to create for the plan")->required();
  add_force_flag(command, &options->replace, "Replace an earlier plan in --out");
  command->add_option("--room", options->room,
                      "Room directory to make, reports go beside it (default: named after the "
                      "folder of the frame list, <folder>.lf)");
  command->add_option("--distance", options->distances,
                      "Directory of distance maps for pack; distances are not estimated then");
  command->add_option("--truth", options->truth,
                      "CSV table of true views, as validate reads it; without it nothing is "
                      "validated");
  command->add_option("--walk", options->walk, "CSV table of views to render, as path reads it");
  command->add_flag("--trade", options->trade,
                    "Also measure speed against accuracy, on nodes of its own; needs --truth");
}

void add_sizes(CLI::App* command, Arguments* arguments) {
  ClusterOptions* options = &arguments->options;
  command
      ->add_option("--minutes-per-block", options->minutes_per_block,
                   "How long a block is to take, minutes")
      ->check(CLI::Range(0.001, 1440.0))
      ->capture_default_str();
  command
      ->add_option("--nodes", options->nodes,
                   "Number of machines; steps have at least as many blocks where they can be "
                   "divided so far")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  command->add_option("--threads-per-task", options->threads_per_task, "Threads of every command")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command
      ->add_option("--most-blocks", options->most_blocks,
                   "Blocks of a step at most; Slurm's limit is MaxArraySize - 1")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command
      ->add_option("--memory-gb", options->memory_gb,
                   "Memory that a task asks Slurm for, GB (default: what the cluster gives)")
      ->check(CLI::Range(0.001, 1e6));
  command
      ->add_option("--rates", arguments->rates,
                   "Megapixels per second and thread of steps, such as depth-sweep=0.3,pack=100; "
                   "docs/cluster.md has the defaults")
      ->type_name("STEP=MPX,...");
}

void write_plan(Arguments* arguments) {
  ClusterOptions& options = arguments->options;
  options.tolerance = tolerance_of(arguments->lines);
  options.rates = parse_rates(arguments->rates);
  for (const std::string& text : arguments->flags) add_flags(text, &options.flags);
  if (options.room.empty()) options.room = default_room_name(options.frames);
  if (options.programs.empty()) options.programs = program_folder();
  const ClusterPlan plan = plan_cluster(
      scale_of(options.frames, options.tolerance, options.truth, options.walk), options);
  write_cluster_folder(plan, options);
  fmt::print("{}Start it: {}\n", text_of(plan),
             escaped((options.out / "submit.sh").string() + " (Slurm) or " +
                     (options.out / "parallel.sh").string() + " (GNU parallel)"));
}

}  // namespace

void add_cluster_plan(CLI::App* app) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app->add_subcommand(
      "cluster-plan", "Write the way from frames to reports as jobs for several machines");
  add_inputs(command, &arguments->options);
  add_sizes(command, arguments.get());
  command
      ->add_option("--add", arguments->flags,
                   "Further flags of a command, such as depth='--width 512'; may be repeated")
      ->type_name("COMMAND=FLAGS");
  command->add_option("--programs", arguments->options.programs,
                      "Folder of Raywalk's programs on the machines (default: that of this one)");
  add_line_tolerance_options(command, &arguments->lines);
  command->footer(
      "Example:\n"
      "  raywalk-build-lf cluster-plan --frames hall/poses.csv --truth hall/gt.csv --out jobs\n"
      "  jobs/submit.sh --partition=long\n"
      "All machines have to see the pictures, the plan, the programs and the room under the same\n"
      "paths. The scripts do what is not done yet, however often they are given.");
  command->callback([arguments] { write_plan(arguments.get()); });
}

}  // namespace raywalk::build_lf
