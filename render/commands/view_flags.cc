#include "render/commands/view_flags.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <vector>

#include "core/command_line/command_options.h"
#include "core/files/words.h"
#include "core/room/tiled_rays.h"
#include "core/view/gpu/gpu_device.h"

namespace raywalk::render {
namespace {

// The groups of the long helps, behind the common flags.
constexpr const char* kConnectionGroup = "Connection";
constexpr const char* kTradeGroup = "Speed against accuracy";

// What a value on the command line has to be. A parameter with a word for 0 checks the text itself.
void add_check(const ViewParameter& parameter, CLI::Option* option) {
  if (parameter.value.kind == ParameterKind::kChoice) {
    option->check(one_of({parameter.names.begin(), parameter.names.end()}));
  } else if (parameter.zero != nullptr) {
    const bool is_word = !parse_finite_number(parameter.zero);
    option->type_name(is_word ? fmt::format("NUMBER|{}", parameter.zero) : "NUMBER");
  } else if (parameter.value.kind == ParameterKind::kInteger) {
    option->type_name("INT")->check(
        CLI::Range(static_cast<int>(parameter.least), static_cast<int>(parameter.most)));
  } else {
    option->type_name("FLOAT")->check(CLI::Range(parameter.least, parameter.most));
  }
}

void add_parameter(CLI::App* command, const ViewParameter& parameter, ViewFlags* flags) {
  const std::string key = parameter.key;
  if (parameter.flag_sets != nullptr) {
    const std::string value = parameter.flag_sets;
    command->add_flag_callback(
        parameter.flag, [flags, key, value] { flags->parameters[key] = value; }, parameter.help);
    return;
  }
  const std::string help =
      fmt::format("{}; default {}", parameter.help, text_of(parameter, default_of(parameter)));
  add_check(parameter,
            command->add_option_function<std::string>(
                parameter.flag,
                [flags, key](const std::string& text) { flags->parameters[key] = text; }, help));
}

void add_parameters(CLI::App* command, ParameterGroup group, ViewFlags* flags) {
  for (const ViewParameter& parameter : kViewParameters) {
    if (parameter.group == group) add_parameter(command, parameter, flags);
  }
}

}  // namespace

void add_room(CLI::App* command, std::string* room) {
  command->add_option("room", *room, "Room directory, made by raywalk-build-lf pack")->required();
  command
      ->add_option_function<double>(
          "--cache-mb",
          [](const double& megabytes) {
            TileCache::of_process().set_limit_bytes(static_cast<std::uint64_t>(1e6 * megabytes));
          },
          "Memory for the decoded panoramas of compressed rooms, MB (default: a quarter of the "
          "machine's)")
      ->check(CLI::Range(1.0, 1e9));
}

void add_connection_flags(CLI::App* command, ViewFlags* flags) {
  takes_config(command->add_option("--settings", flags->settings,
                                   "YAML file of settings, as configs/view.yaml, or the name of "
                                   "one there; flags override it"),
               ConfigKind::kView);
  command
      ->add_option("--preset", flags->preset,
                   "Defaults for the other flags: fast, balanced or accurate")
      ->check(one_of({kPresets.begin(), kPresets.end()}));
  command->option_defaults()->group(kConnectionGroup);
  command
      ->add_option("--connection", flags->connection,
                   "Where lines connect: hybrid (default), lfu (k = 45) or rayspace360 (k = 90)")
      ->check(one_of({kConnections.begin(), kConnections.end()}));
  add_parameters(command, ParameterGroup::kConnection, flags);
  command->option_defaults()->group(kTradeGroup);
  add_parameters(command, ParameterGroup::kTrade, flags);
}

void add_demand_flags(CLI::App* command, Demand* demand) {
  command->option_defaults()->group(kTradeGroup);
  command->add_option(
      "--budget-ms", demand->budget_ms,
      "Use the most accurate setting that renders a panorama within this many milliseconds, "
      "as measured on the room by raywalk-render trade");
  command
      ->add_option("--min-psnr-db", demand->min_psnr_db,
                   "Use the fastest setting that reached this PSNR in that measurement")
      ->check(CLI::Range(0.0, kMostPsnr_db));
}

void add_view_flags(CLI::App* command, ViewFlags* flags) {
  add_parameters(command, ParameterGroup::kView, flags);
  add_connection_flags(command, flags);
}

void add_device_flags(CLI::App* command, const std::string& usual, DeviceFlags* flags) {
  flags->device = usual;
  command
      ->add_option("--device", flags->device,
                   "What mixes the stations: cpu, gpu, or auto (a graphics card if there is one); "
                   "default " +
                       usual)
      ->check(one_of({kDeviceNames.begin(), kDeviceNames.end()}));
  command
      ->add_option("--gpu-mb", flags->gpu_mb,
                   fmt::format("Most memory of the graphics card for panoramas, MB (default {:g})",
                               kUsualGpu_mb))
      ->check(CLI::Range(1.0, 1e7));
}

void use_device(const DeviceFlags& flags) {
  choose_device(device_from_name(flags.device), flags.gpu_mb);
  if (on_graphics_card()) fmt::print("device: {}\n", device_name());
}

void add_quality_flag(CLI::App* command, std::optional<int>* quality) {
  command->add_option("--quality", *quality, "Quality of JPEG and WebP, 1 to 100 (default 95)")
      ->check(CLI::Range(1, 100));
}

void add_flat_flags(CLI::App* command, ViewFrame* frame) {
  command->option_defaults()->group(kDirectionGroup);
  command
      ->add_option(
          "--fov-deg", frame->fov_deg,
          "Horizontal field of view in degrees of a flat picture; without it a panorama is "
          "rendered")
      ->check(CLI::Range(1e-3, kMaxFovDeg));
  command
      ->add_option("--size", frame->size,
                   "Size of the flat picture, WIDTHxHEIGHT in pixels (default 1280x720)")
      ->type_name("WIDTHxHEIGHT");
}

void add_stereo_flags(CLI::App* command, ViewFrame* frame) {
  command->option_defaults()->group(kDirectionGroup);
  command
      ->add_option_function<std::string>(
          "--stereo", [frame](const std::string&) { frame->stereo = Stereo::kOds; },
          "ods: two panoramas, the left eye's above the right eye's, for headsets; each column is "
          "seen "
          "from its own place on a circle around the viewpoint")
      ->check(one_of({"ods"}));
  command
      ->add_option(
          "--ipd-mm", frame->ipd_mm,
          fmt::format("Distance between the eyes in millimetres (default {:g})", kUsualIpd_mm))
      ->check(CLI::Range(kLeastIpd_mm, kMostIpd_mm));
}

Preset chosen_settings(const ViewFlags& flags, const Demand& demand, const Room& room) {
  Preset preset = settings_for(flags, demand, room);
  if (!preset.reason.empty()) fmt::print("{}\n", preset.reason);
  return preset;
}

ViewMode chosen_mode(const ViewFlags& flags, const Demand& demand, const Room& room) {
  return mode_of(chosen_settings(flags, demand, room));
}

}  // namespace raywalk::render
