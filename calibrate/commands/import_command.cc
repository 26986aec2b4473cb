// import: poses of other programs.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "calibrate/commands/commands.h"
#include "calibrate/import/import_poses.h"
#include "core/base/error.h"
#include "core/command_line/command_options.h"
#include "core/files/words.h"

namespace raywalk::calibrate {
namespace {

struct ImportArguments {
  ImportOptions options{};
  std::string axes = "fit";
  double spacing_mm = 0.0;
  std::vector<std::string> distance{};
};

KnownDistance known_distance(const std::vector<std::string>& words) {
  const std::optional<double> metres = parse_finite_number(words[2]);
  if (!metres || *metres <= 0.0) {
    throw UsageError(fmt::format("--distance: {} is not a distance in metres", excerpt(words[2])));
  }
  return {words[0], words[1], *metres};
}

void run(const ImportArguments& arguments) {
  ImportOptions options = arguments.options;
  options.axes.fit = arguments.axes == "fit";
  if (arguments.spacing_mm > 0.0) options.axes.scale.spacing_m = arguments.spacing_mm / 1000.0;
  if (!arguments.distance.empty()) options.axes.scale.distance = known_distance(arguments.distance);
  fmt::print("{}\n", import_poses(options));
}

void add_scale_options(CLI::App* command, ImportArguments* arguments) {
  KnownScale* scale = &arguments->options.axes.scale;
  auto* group =
      command->add_option_group("Scale", "One of these says how long the source's unit is");
  group->add_option("--scale", scale->metres_per_unit, "Metres per unit of the source; 1 = metres")
      ->check(CLI::PositiveNumber);
  group->add_option("--cell-m", scale->cell_m, "Side of the grid's cells in metres (their mean)")
      ->check(CLI::PositiveNumber);
  group
      ->add_option("--spacing-mm", arguments->spacing_mm,
                   "Distance of neighbouring stations in millimetres (their median)")
      ->check(CLI::PositiveNumber);
  group
      ->add_option("--distance", arguments->distance,
                   "Two panoramas and their distance in metres: A B METRES")
      ->expected(3);
  group->add_option("--reference", arguments->options.reference,
                    "Frame list file,x,y,z of known positions, in metres, of at least three "
                    "panoramas: gives the axes too");
  group->require_option(0, 1);
}

}  // namespace

void add_import(CLI::App* app) {
  CLI::App* command =
      app->add_subcommand("import", "Take the poses of panoramas from another program");
  auto arguments = std::make_shared<ImportArguments>();
  ImportOptions* options = &arguments->options;
  command
      ->add_option(
          "poses", options->source,
          "Folder of a COLMAP model of faces or panoramas, nerfstudio's transforms.json, or "
          "a frame list: file,x,y,z in metres, [yaw,pitch,roll]")
      ->required();
  command->add_option("--panoramas", options->panoramas,
                      "Folder of the panoramas (default: where the source says)");
  command->add_option(
      "--faces", options->faces,
      "Table folder,yaw,pitch,roll in degrees of the faces that a COLMAP model is of "
      "(default: those of raywalk-build-lf export)");
  command
      ->add_option("--axes", arguments->axes,
                   "fit: turn the lines along x and z, up along y; keep: as in the source")
      ->check(one_of({"fit", "keep"}))
      ->capture_default_str();
  add_scale_options(command, arguments.get());
  command->add_option("-o,--out", options->out, "Directory for poses.csv and import.json")
      ->required();
  add_force_flag(command, &options->replace, "Replace an earlier import in --out");
  add_line_tolerance_options(command, &options->axes.tolerance);
  command->footer(
      "Examples:\n  raywalk-calibrate import sparse/0 --panoramas pictures --cell-m 1.2 --out "
      "hall\n"
      "  raywalk-build-lf pack --frames hall/poses.csv\n"
      "  raywalk-calibrate import positions.csv --out street\n"
      "Panoramas are not copied or changed; pack turns them as poses.csv says.");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace raywalk::calibrate
