// The way from frames to reports as steps of many commands, which a cluster or several machines do:
// `raywalk-build-lf cluster-plan`.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "build_lf/cluster/room_scale.h"
#include "build_lf/cluster/step_rates.h"

namespace raywalk::build_lf {

struct ClusterOptions {
  std::filesystem::path frames{};                    // the frame list, poses.csv
  std::filesystem::path out{};                       // the folder to create
  bool replace = false;                              // an earlier plan in `out` is replaced
  std::filesystem::path room{};                      // the room to make; reports go beside it
  std::optional<std::filesystem::path> distances{};  // given to pack; none are estimated then
  std::optional<std::filesystem::path> truth{};      // true views; none: no validation
  std::optional<std::filesystem::path> walk{};       // views to render; none: none
  bool trade = false;                                // needs true views
  GridTolerance tolerance{};
  double minutes_per_block = 5.0;     // above 0
  int nodes = 1;                      // at least so many blocks where a step has them, at least 1
  int threads_per_task = 4;           // at least 1
  int most_blocks = 1000;             // of a step; Slurm's own limit is 1000 unless it is changed
  std::optional<double> memory_gb{};  // that a task asks for; none: what the cluster gives
  GivenRates rates{};
  // Further flags of commands, by command ("depth"), as the shell is to read them.
  std::map<std::string, std::string> flags{};
  std::filesystem::path programs{};  // the folder of Raywalk's programs
};

// A step: commands that may run in any order, on any machines.
struct ClusterStep {
  std::string name{};                   // "depth-sweep"
  std::vector<std::string> commands{};  // lines for a POSIX shell, with absolute paths
  std::vector<std::string> after{};     // earlier steps, all of whose commands have to be done
  double minutes = 0.0;                 // that each command is thought to take
  bool alone = false;                   // measures time: nothing may run beside it
};

struct ClusterPlan {
  RoomScale scale{};
  std::vector<ClusterStep> steps{};  // in an order in which they can be done
};

// The steps from frames to reports. A step of one block is one command; one of several has another
// step behind it that merges them. Paths are made absolute. Throws UsageError for a path with a
// line break, flags of a command that the plan does not have, a trade without true views, and
// numbers out of range.
ClusterPlan plan_cluster(const RoomScale& scale, const ClusterOptions& options);

// `word` such that a POSIX shell takes it as one word, unchanged: as it is where it has letters,
// digits and harmless signs only, else in single quotes.
std::string shell_quoted(std::string_view word);

}  // namespace raywalk::build_lf
