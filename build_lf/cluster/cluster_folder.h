// The folder of a cluster plan: lists of commands, scripts for Slurm, and one for GNU parallel.
//
//   README.txt          the steps: how many blocks, what they wait for, how long they may take
//   steps.txt           the same for the scripts
//   commands/STEP.txt   one command a line
//   slurm/STEP.sbatch   an array job over these lines; slurm/finish.sbatch: the last job
//   submit.sh, parallel.sh, finish.sh, task.sh, slurm-task.sh, steps.sh (build_lf/cluster/scripts)
//   state, logs, missing.txt: made while the plan is carried out
#pragma once

#include <string>

#include "build_lf/cluster/cluster_plan.h"

namespace raywalk::build_lf {

// Writes the folder options.out; it appears when it is complete. Throws Error if something is there
// (with options.replace: something else than a plan), or if it cannot be written.
void write_cluster_folder(const ClusterPlan& plan, const ClusterOptions& options);

// The plan as a table with a line for each step.
std::string text_of(const ClusterPlan& plan);

}  // namespace raywalk::build_lf
