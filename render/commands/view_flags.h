// Options of the commands that render views.
#pragma once

#include <optional>
#include <string>

#include "core/view/gpu/gpu_device.h"
#include "render/view/measured_choice.h"
#include "render/view/picture_format.h"
#include "render/view/presets.h"
#include "render/view/view_frame.h"
#include "render/view/view_settings.h"

namespace CLI {
class App;
}

namespace raywalk::render {

// All variables that the functions below are given have to outlive the command.

// The room directory, a positional argument.
void add_room(CLI::App* command, std::string* room);

// --method, --width and those of add_connection_flags.
void add_view_flags(CLI::App* command, ViewFlags* flags);

// --settings, --preset, --connection and the flags of all other parameters.
void add_connection_flags(CLI::App* command, ViewFlags* flags);

// --budget-ms and --min-psnr-db, for rooms that a trade was measured on.
void add_demand_flags(CLI::App* command, Demand* demand);

// --device and --gpu-mb.
struct DeviceFlags {
  std::string device{};
  double gpu_mb = kUsualGpu_mb;
};
void add_device_flags(CLI::App* command, const std::string& usual, DeviceFlags* flags);
// Of all views from now on; names a graphics card that is used.
void use_device(const DeviceFlags& flags);

// --quality of pictures.
void add_quality_flag(CLI::App* command, std::optional<int>* quality);

// --fov-deg and --size.
void add_flat_flags(CLI::App* command, ViewFrame* frame);

// --stereo and --ipd-mm.
void add_stereo_flags(CLI::App* command, ViewFrame* frame);

// The group of the flags that say where a view looks.
inline constexpr const char* kDirectionGroup = "Direction and flat pictures";

// The settings for a room; prints the reason where a preset or a measurement chose them. Throws as
// preset_settings() and demanded_settings() do.
Preset chosen_settings(const ViewFlags& flags, const Demand& demand, const Room& room);

// The mode for a room of views that these flags ask for.
ViewMode chosen_mode(const ViewFlags& flags, const Demand& demand, const Room& room);

}  // namespace raywalk::render
