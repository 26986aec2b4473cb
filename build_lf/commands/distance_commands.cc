// Commands of what is estimated for a room: depth, distances, gains.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>

#include "build_lf/commands/commands.h"
#include "build_lf/depth/estimate_depth.h"
#include "build_lf/exposure/make_gains.h"
#include "build_lf/pack/distance_sets.h"
#include "core/base/error.h"
#include "core/base/escaped.h"
#include "core/base/parallel.h"
#include "core/command_line/command_options.h"

namespace raywalk::build_lf {
namespace {

struct DepthArguments {
  DepthOptions options{};
  std::string method = "sweep";
  std::string step{};
  std::optional<WorkPart> part{};
  int threads = 0;
};

struct GainsArguments {
  std::string room{};
  bool remove = false;
  int threads = 0;
};

struct DistancesArguments {
  std::string room{};
  std::string use{};
};

}  // namespace

void add_depth(CLI::App* app) {
  auto arguments = std::make_shared<DepthArguments>();
  DepthOptions* options = &arguments->options;
  CLI::App* depth = app->add_subcommand("depth", "Estimate distances from the captured panoramas");
  depth->add_option("room", options->room, "Room directory")->required();
  depth
      ->add_option("--method", arguments->method,
                   "sweep: many stations of all lines (default); flow: optical flow along a line")
      ->type_name("sweep|flow");
  depth->add_option("--every", options->every,
                    "A map at every n-th station; 0 = chosen from the cell size");
  depth->add_option("--width", options->width,
                    "Width of the maps in pixels; 0 = as captured, at most 1024");
  depth->add_option("--valid-mask", options->valid_mask,
                    "Mask for all panoramas, a grey image in world axes; black pixels are ignored");
  depth->add_option("--hold-out", options->hold_out,
                    "Leave out one of every n stations and write the maps to room.lf/held-out, for "
                    "raywalk-render trade --held-out; 0 = use all");
  depth->add_flag_callback(
      "--keep-moving", [options] { options->leave_out_moving = false; },
      "Also use what single stations show and the others contradict: people and cars that moved");
  depth->add_flag("--truth", options->compare_truth,
                  "Compare with the distances packed with the room");
  depth->add_flag("!--no-gains", options->gains,
                  "Leave the room's gains as they are (default: those found while estimating)");
  depth
      ->add_option("--step", arguments->step,
                   "Do only this step; each needs those before it: " + depth_step_names())
      ->type_name("STEP");
  add_part_option(depth, &arguments->part, "step");
  add_threads_option(depth, &arguments->threads);
  depth->footer(
      "Examples:\n  raywalk-build-lf depth room.lf\n"
      "  raywalk-build-lf depth room.lf --step sweep --part 1/16\n"
      "Views then use the estimated distances; those packed with the room are kept, and\n"
      "`raywalk-build-lf distances` goes back to them.");
  add_resumption(depth);
  depth->callback([arguments, options] {
    options->method = depth_method_from_name(arguments->method);
    set_thread_count(arguments->threads);
    if (!arguments->step.empty()) {
      const DepthStep step = depth_step_from_name(arguments->step);
      fmt::print("{}\n",
                 escaped(estimate_step(*options, step, arguments->part.value_or(WorkPart{}))));
      return;
    }
    if (arguments->part) throw UsageError("--part: give --step too: " + depth_step_names());
    const DepthSummary summary = estimate_depth(*options);
    fmt::print("{}", text_of(summary));
    require_usable(summary);
  });
}

void add_distances(CLI::App* app) {
  auto arguments = std::make_shared<DistancesArguments>();
  CLI::App* distances = app->add_subcommand(
      "distances", "Show which distances views use, and switch between given and estimated ones");
  distances->add_option("room", arguments->room, "Room directory")->required();
  CLI::Option* use =
      distances
          ->add_option("--use", arguments->use,
                       "Let views use these: given (packed with the room) or estimated (by depth)")
          ->type_name("given|estimated");
  distances->footer(
      "Examples:\n  raywalk-build-lf distances room.lf\n"
      "  raywalk-build-lf distances room.lf --use given");
  distances->callback([arguments, use] {
    if (*use) {
      fmt::print("{}\n", use_distances(arguments->room, distance_kind_from_name(arguments->use)));
    } else {
      fmt::print("{}", distances_text(arguments->room));
    }
  });
}

void add_gains(CLI::App* app) {
  auto arguments = std::make_shared<GainsArguments>();
  CLI::App* gains = app->add_subcommand(
      "gains", "Make the exposures of a room's panoramas agree in views, also locally");
  gains->add_option("room", arguments->room, "Room directory")->required();
  gains->add_flag("--remove", arguments->remove, "Remove the room's gains instead");
  add_threads_option(gains, &arguments->threads);
  gains->footer(
      "Example:\n  raywalk-build-lf gains room.lf\n"
      "The gains are solved from surfaces that several stations see, so the room needs distances;\n"
      "`depth` does the same. Panoramas are not changed: views multiply what they read, unless\n"
      "they are rendered with --no-gains.");
  gains->callback([arguments] {
    set_thread_count(arguments->threads);
    if (!arguments->remove) {
      const std::string text = text_of(make_gains(arguments->room));
      fmt::print("{}\n", escaped(arguments->room + ": " + text));
      return;
    }
    const bool removed = remove_gains(arguments->room);
    fmt::print("{}\n",
               escaped(arguments->room + (removed ? ": the gains are removed" : ": has no gains")));
  });
}

}  // namespace raywalk::build_lf
