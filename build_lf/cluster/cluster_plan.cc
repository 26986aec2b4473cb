#include "build_lf/cluster/cluster_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "build_lf/refine/refine_plan.h"
#include "core/base/error.h"
#include "core/files/output_folder.h"
#include "core/room/refined_record.h"

namespace raywalk::build_lf {
namespace {

namespace fs = std::filesystem;

// As connect-error has it unless told otherwise.
constexpr double kViewpointsPerCell = 49.0 * 49.0;
// How many true views a trade takes.
constexpr int kTradeViews = 6;

std::string path_word(const fs::path& path) {
  const std::string text = fs::absolute(path).lexically_normal().string();
  if (text.find_first_of("\r\n") != std::string::npos) {
    throw UsageError(excerpt(text) + ": a list of commands cannot hold a line break; rename it");
  }
  return shell_quoted(text);
}

// "hall.lf" and "walk": "hall-walk" beside it.
fs::path beside_room(const fs::path& room, const std::string& what) {
  const fs::path whole = without_trailing_slash(room);
  return whole.parent_path() / (whole.stem().string() + "-" + what);
}

class Planner {
 public:
  Planner(const RoomScale& scale, const ClusterOptions& options)
      : scale_(scale), options_(options), room_(path_word(options.room)) {}

  std::vector<ClusterStep> steps() {
    add_pack();
    if (!options_.distances) add_depth();
    add_refine();
    if (scale_.cells > 0) add_connect_error();
    add_require();
    const std::vector<std::string> measured = ends_;
    if (options_.truth) add_validate(measured);
    if (options_.walk) add_path(measured);
    if (options_.trade) add_trade(measured);
    return std::move(steps_);
  }

 private:
  // A command line with the flags that the user adds to it.
  std::string command(const std::string& program, const std::string& name,
                      const std::string& arguments) const {
    std::string line = fmt::format("{} {} {} --threads {}", path_word(options_.programs / program),
                                   name, arguments, options_.threads_per_task);
    const auto more = options_.flags.find(name);
    return more == options_.flags.end() ? line : line + " " + more->second;
  }
  std::string build_lf(const std::string& name, const std::string& arguments) const {
    return command("raywalk-build-lf", name, arguments);
  }
  std::string render(const std::string& name, const std::string& arguments) const {
    return command("raywalk-render", name, arguments);
  }
  std::string report(const std::string& what) const {
    return path_word(beside_room(options_.room, what));
  }

  double minutes_of(const std::string& step, double mpx) const {
    return mpx / rate_of(step, options_.rates) / options_.threads_per_task / 60.0;
  }

  // How many blocks do `minutes` of work of which `parts` can be told apart.
  int blocks_of(double minutes, int parts) const {
    const double blocks =
        std::max<double>(std::ceil(minutes / options_.minutes_per_block), options_.nodes);
    return static_cast<int>(std::min<double>({blocks, static_cast<double>(std::max(parts, 1)),
                                              static_cast<double>(options_.most_blocks)}));
  }

  void add_step(const std::string& name, std::vector<std::string> commands,
                std::vector<std::string> after, double minutes) {
    ends_ = {name};
    steps_.push_back({name, std::move(commands), std::move(after), minutes});
  }

  // One command for each block.
  void add_blocks(const std::string& name, const std::string& line, int blocks,
                  std::vector<std::string> after, double minutes) {
    std::vector<std::string> commands;
    for (int i = 1; i <= blocks; ++i) {
      commands.push_back(fmt::format("{} --block {}/{}", line, i, blocks));
    }
    add_step(name, std::move(commands), std::move(after), minutes / blocks);
  }

  // A step that is done at once, or in blocks that are merged.
  void add_divided(const std::string& name, const std::string& line, double mpx, int parts,
                   const std::vector<std::string>& after) {
    const double minutes = minutes_of(name, mpx);
    const int blocks = blocks_of(minutes, parts);
    if (blocks == 1) return add_step(name, {line}, after, minutes);
    add_blocks(name, line, blocks, after, minutes);
    add_step(name + "-merge", {line + " --merge"}, {name}, 1.0);
  }

  void add_pack() {
    std::string arguments = fmt::format("--frames {} --out {}", path_word(options_.frames), room_);
    if (options_.distances) arguments += " --distance " + path_word(*options_.distances);
    if (const auto& most_m = options_.tolerance.off_line_m) {
      arguments += fmt::format(" --line-tolerance-mm {}", *most_m * 1e3);
    }
    if (const auto& same_m = options_.tolerance.same_station_m) {
      arguments += fmt::format(" --same-station-mm {}", *same_m * 1e3);
    }
    add_divided("pack", build_lf("pack", arguments), scale_.stations * scale_.panorama_mpx(),
                scale_.lines, {});
  }

  // A step of depth, with the pixels that it is counted in and the pieces that it is divided into.
  struct DepthPart {
    std::string step;
    double mpx;
    int pieces;
  };

  std::vector<DepthPart> depth_parts() const {
    const double stations_mpx = scale_.stations * scale_.panorama_mpx();
    const double maps_mpx = scale_.maps * scale_.map_mpx();
    std::vector<DepthPart> parts{{"links", stations_mpx, scale_.stations - scale_.lines}};
    // Only where there are no cells.
    if (scale_.cells == 0) parts.push_back({"reach", maps_mpx, scale_.maps});
    for (const char* step : {"surfaces", "colours", "sweep", "choose", "fuse"}) {
      parts.push_back({step, maps_mpx, scale_.maps});
    }
    parts.push_back({"moved", maps_mpx, scale_.stations});
    parts.push_back({"volumes", maps_mpx, scale_.lines});
    parts.push_back({"gains", maps_mpx, scale_.stations});
    return parts;
  }

  // Each step needs the one before.
  void add_depth() {
    const std::string line = build_lf("depth", room_);
    const std::vector<DepthPart> parts = depth_parts();
    const auto minutes = [&](const DepthPart& part) {
      return minutes_of("depth-" + part.step, part.mpx);
    };
    double all = 0.0;
    for (const DepthPart& part : parts) all += minutes(part);
    if (blocks_of(all, scale_.maps) == 1) return add_step("depth", {line}, ends_, all);
    for (const DepthPart& part : parts) {
      const std::string name = "depth-" + part.step;
      const std::string step = line + " --step " + part.step;
      add_blocks(name, step, blocks_of(minutes(part), part.pieces), ends_, minutes(part));
      // What colours tell is solved for as a whole, before every block of the next step needs it.
      if (part.step == "colours") add_step(name + "-merge", {step + " --merge"}, ends_, 1.0);
    }
    add_step("depth-merge", {line + " --merge"}, ends_, 1.0);
  }

  // What comes after it is of the refined room.
  void add_refine() {
    scale_.stations = scale_.maps;
    const int width = developed_width(scale_.panorama, 0);
    scale_.panorama = {width, width / 2};
    add_divided("refine", build_lf("refine", room_), scale_.stations * scale_.panorama_mpx(),
                scale_.stations, ends_);
    room_ = path_word(refined_room_path(options_.room));
  }

  void add_connect_error() {
    add_step(
        "connect-error", {render("connect-error", room_ + " --generation initial,hlf-vd")}, ends_,
        minutes_of("connect-error", scale_.cells * kViewpointsPerCell * scale_.panorama_mpx()));
  }

  // After connect-error, whose result its report shows.
  void add_require() {
    add_step("require", {build_lf("require", room_ + " --report " + report("require"))}, ends_,
             minutes_of("require", scale_.stations * scale_.panorama_mpx()));
  }

  void add_validate(const std::vector<std::string>& after) {
    add_step("validate",
             {render("validate", fmt::format("{} --truth {} --report {}", room_,
                                             path_word(*options_.truth), report("validate")))},
             after, minutes_of("validate", scale_.truth_views * scale_.panorama_mpx()));
  }

  void add_path(const std::vector<std::string>& after) {
    add_divided("path",
                render("path", fmt::format("{} {} --out {}", room_, path_word(*options_.walk),
                                           report("walk"))),
                scale_.walk_views * scale_.panorama_mpx(), scale_.walk_views, after);
  }

  void add_trade(const std::vector<std::string>& after) {
    add_step("trade",
             {render("trade", fmt::format("{} --truth {} --report {}", room_,
                                          path_word(*options_.truth), report("trade")))},
             after, minutes_of("trade", kTradeViews * scale_.panorama_mpx()));
    steps_.back().alone = true;
  }

  RoomScale scale_;
  const ClusterOptions& options_;
  std::string room_;
  std::vector<ClusterStep> steps_{};
  std::vector<std::string> ends_{};  // the last step
};

void check(const ClusterOptions& options) {
  if (!(options.minutes_per_block > 0.0) || options.nodes < 1 || options.threads_per_task < 1 ||
      options.most_blocks < 1 || (options.memory_gb && !(*options.memory_gb > 0.0))) {
    throw UsageError("minutes, nodes, threads, blocks and memory of a cluster plan are above 0");
  }
  if (options.trade && !options.truth) {
    throw UsageError("--trade compares with true views; give --truth too");
  }
  for (const auto& [name, flags] : options.flags) {
    constexpr std::array kCommands{"pack",    "depth",    "refine", "connect-error",
                                   "require", "validate", "path",   "trade"};
    if (std::ranges::find(kCommands, name) == kCommands.end()) {
      throw UsageError(fmt::format("--add: unknown command {}; use {}", excerpt(name),
                                   fmt::join(kCommands, ", ")));
    }
    if (flags.find_first_of("\r\n") != std::string::npos) {
      throw UsageError("--add " + name + ": flags with a line break");
    }
  }
}

}  // namespace

ClusterPlan plan_cluster(const RoomScale& scale, const ClusterOptions& options) {
  check(options);
  return {scale, Planner(scale, options).steps()};
}

std::string shell_quoted(std::string_view word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789/._-+,:@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string_view::npos) {
    return std::string(word);
  }
  std::string quoted = "'";
  for (const char c : word) {
    // A quote ends the quoted part, stands alone, and begins the next.
    if (c == '\'') {
      quoted += R"('\'')";
    } else {
      quoted += c;
    }
  }
  return quoted + "'";
}

}  // namespace raywalk::build_lf
