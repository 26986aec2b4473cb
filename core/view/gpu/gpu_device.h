// The device that views are rendered on, chosen once for the whole program.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "core/room/room.h"

namespace raywalk {

class GpuRenderer;

// kAuto: a graphics card, if there is one, else the processor. kGpu: the same, and where there is
// no card what stands in for one (Mesa's llvmpipe); a warning where there is nothing.
enum class Device { kCpu, kGpu, kAuto };
inline constexpr std::array kDeviceNames{"cpu", "gpu", "auto"};
// Throws UsageError for another name.
Device device_from_name(const std::string& name);
inline constexpr double kUsualGpu_mb = 4096.0;

// Of all renderers that are made from now on; before, the processor. Takes at most `gpu_mb` of the
// card's memory for panoramas.
void choose_device(Device device, double gpu_mb = kUsualGpu_mb);

// Whether a card, or what stands in for one, was found; and its driver's name of it.
bool on_graphics_card();
std::string device_name();

// What renders views of a room on the chosen card; null: the processor does. Renderers of one room
// share its panoramas there, which are shown with the stations' gains or without.
// Throws GpuError (gpu_context.h) where no panorama fits.
std::unique_ptr<GpuRenderer> make_gpu_renderer(const Room& room, bool gains);

// Says once for a choice why the card did not do something, which the processor does then.
void warn_of_gpu(const std::string& reason);

}  // namespace raywalk
