#include "build_lf/cluster/cluster_folder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "cluster_scripts.h"
#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "core/files/output_folder.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMarker = "README.txt";
constexpr const char* kSignature = "A plan of Raywalk's for a cluster";

struct Script {
  const char* name;
  const char* text;
};
constexpr std::array kScripts{
    Script{"submit.sh", kSubmitScript},        Script{"parallel.sh", kParallelScript},
    Script{"finish.sh", kFinishScript},        Script{"task.sh", kTaskScript},
    Script{"slurm-task.sh", kSlurmTaskScript}, Script{"steps.sh", kStepsScript},
};

bool is_part_of_plan(const fs::path& relative, bool is_directory) {
  constexpr std::array kFolders{"commands", "slurm", "state", "logs"};
  constexpr std::array kFiles{"README.txt", "steps.txt", "missing.txt"};
  const std::string top = relative.begin()->string();
  if (std::ranges::find(kFolders, top) != kFolders.end()) return true;
  return !is_directory && (std::ranges::find(kFiles, top) != kFiles.end() ||
                           std::ranges::find(kScripts, top, &Script::name) != kScripts.end());
}

// A task that takes longer has failed: it may be on a slow machine, but not on that slow a one.
int limit_minutes(double minutes) {
  constexpr double kSlower = 10.0;
  constexpr double kLeast = 60.0;
  return static_cast<int>(std::ceil(std::max(kLeast, kSlower * minutes)));
}

// The options of Slurm for a job; its body is one line. Paths are relative to the folder, in which
// submit.sh starts it.
std::string batch_script(const std::string& name, const std::string& options,
                         const std::string& body) {
  return fmt::format(
      "#!/usr/bin/env bash\n"
      "#SBATCH --job-name=raywalk-{}\n"
      "#SBATCH --nodes=1 --ntasks=1\n"
      "{}"
      "exec {}\n",
      name, options, body);
}

std::string step_script(const ClusterStep& step, const ClusterOptions& options) {
  std::string text = fmt::format(
      "#SBATCH --array=1-{}\n"
      "#SBATCH --cpus-per-task={}\n"
      "#SBATCH --time={}\n"
      "#SBATCH --requeue\n"
      "#SBATCH --open-mode=append\n"
      "#SBATCH --output=logs/{}-%a.log\n",
      step.commands.size(), options.threads_per_task, limit_minutes(step.minutes), step.name);
  if (options.memory_gb) {
    text += fmt::format("#SBATCH --mem={}M\n", std::ceil(*options.memory_gb * 1024.0));
  }
  if (step.alone) text += "#SBATCH --exclusive\n";
  return batch_script(step.name, text,
                      fmt::format("./slurm-task.sh {} \"$SLURM_ARRAY_TASK_ID\"", step.name));
}

std::string finish_script() {
  return batch_script("finish",
                      fmt::format("#SBATCH --time={}\n"
                                  "#SBATCH --requeue\n"
                                  "#SBATCH --output=logs/finish.log\n",
                                  limit_minutes(0.0)),
                      "./finish.sh");
}

std::string after_text(const ClusterStep& step, const char* separator) {
  return step.after.empty() ? "-" : fmt::format("{}", fmt::join(step.after, separator));
}

std::string steps_table(const ClusterPlan& plan) {
  std::string text;
  for (const ClusterStep& step : plan.steps) {
    text += fmt::format("{} {} {}\n", step.name, step.commands.size(), after_text(step, ","));
  }
  return text;
}

std::string readme_of(const ClusterPlan& plan) {
  return fmt::format(
      "{}.\n"
      "Every machine has to see this folder, the pictures, the programs and the room under the "
      "same\n"
      "paths.\n\n"
      "  ./submit.sh      hands all steps to Slurm; options are those of sbatch\n"
      "  ./parallel.sh    does them by GNU parallel, with --sshlogin on several machines\n"
      "  ./finish.sh      says what is missing\n\n"
      "Each does only what is not done yet, so that it is given again after a failure. Remove the\n"
      "folder state to have all looked at again; blocks that are there are not made again.\n\n"
      "{}\n",
      kSignature, text_of(plan));
}

void write_scripts(const fs::path& folder) {
  for (const Script& script : kScripts) {
    write_file_atomically(folder / script.name, std::string_view(script.text));
    fs::permissions(folder / script.name,
                    fs::perms::owner_exec | fs::perms::group_exec | fs::perms::others_exec,
                    fs::perm_options::add);
  }
}

void write_files(const ClusterPlan& plan, const ClusterOptions& options, const fs::path& folder) {
  make_directories(folder / "commands");
  make_directories(folder / "slurm");
  for (const ClusterStep& step : plan.steps) {
    write_file_atomically(folder / "commands" / (step.name + ".txt"),
                          fmt::format("{}\n", fmt::join(step.commands, "\n")));
    write_file_atomically(folder / "slurm" / (step.name + ".sbatch"), step_script(step, options));
  }
  write_file_atomically(folder / "slurm" / "finish.sbatch", finish_script());
  write_file_atomically(folder / "steps.txt", steps_table(plan));
  write_scripts(folder);
  write_file_atomically(folder / kMarker, readme_of(plan));
}

}  // namespace

void write_cluster_folder(const ClusterPlan& plan, const ClusterOptions& options) {
  OutputFolder folder(options.out, options.replace,
                      {"a cluster plan", kMarker, kSignature, is_part_of_plan});
  write_files(plan, options, folder.directory());
  folder.complete();
}

std::string text_of(const ClusterPlan& plan) {
  const RoomScale& scale = plan.scale;
  std::string text =
      fmt::format("{} stations on {} lines, {} cells, {} x {}\n", scale.stations, scale.lines,
                  scale.cells, scale.panorama.width, scale.panorama.height);
  text += fmt::format("  {:<20}{:>7}{:>14}   {}\n", "step", "blocks", "minutes each", "after");
  for (const ClusterStep& step : plan.steps) {
    text += fmt::format("  {:<20}{:>7}{:>14.1f}   {}\n", step.name, step.commands.size(),
                        step.minutes, after_text(step, ", "));
  }
  return text;
}

}  // namespace raywalk::build_lf
