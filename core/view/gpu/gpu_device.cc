#include "core/view/gpu/gpu_device.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <map>
#include <mutex>
#include <utility>

#include "core/base/error.h"
#include "core/view/gpu/gpu_context.h"
#include "core/view/gpu/gpu_renderer.h"
#include "core/view/gpu/room_textures.h"

namespace raywalk {
namespace {

// Textures are shared by the renderers of a room with the same gains.
using SharedBy = std::pair<const Room*, bool>;

struct Chosen {
  std::mutex mutex;
  // Not closed at the end of the program, when the driver's own data may be gone.
  GpuContext* opened = nullptr;
  GpuContext* context = nullptr;  // that views are rendered on: the same, or none
  std::uint64_t most_bytes = 0;
  std::map<SharedBy, std::weak_ptr<RoomTextures>> textures;
  bool warned = false;
};

Chosen& chosen() {
  static auto* const chosen = new Chosen;
  return *chosen;
}

}  // namespace

Device device_from_name(const std::string& name) {
  for (std::size_t i = 0; i < kDeviceNames.size(); ++i) {
    if (name == kDeviceNames[i]) return static_cast<Device>(i);
  }
  throw UsageError(
      fmt::format("device {} is unknown; use {}", excerpt(name), fmt::join(kDeviceNames, ", ")));
}

void choose_device(Device device, double gpu_mb) {
  Chosen& now = chosen();
  const std::lock_guard lock(now.mutex);
  now.context = nullptr;
  now.warned = false;
  now.most_bytes = static_cast<std::uint64_t>(1e6 * gpu_mb);
  if (device == Device::kCpu) return;
  try {
    const bool software = device == Device::kGpu;
    if (now.opened == nullptr || (now.opened->is_software() && !software)) {
      now.opened = GpuContext::open(software).release();
    }
    now.context = now.opened;
  } catch (const GpuError& error) {
    if (device == Device::kGpu) spdlog::warn("{}; the processor renders views", error.what());
  }
}

bool on_graphics_card() {
  const std::lock_guard lock(chosen().mutex);
  return chosen().context != nullptr;
}

std::string device_name() {
  const std::lock_guard lock(chosen().mutex);
  return chosen().context == nullptr ? "the processor" : chosen().context->name();
}

std::unique_ptr<GpuRenderer> make_gpu_renderer(const Room& room, bool gains) {
  Chosen& now = chosen();
  const std::lock_guard lock(now.mutex);
  if (now.context == nullptr) return nullptr;
  std::weak_ptr<RoomTextures>& shared = now.textures[{&room, gains}];
  std::shared_ptr<RoomTextures> textures = shared.lock();
  if (!textures) {
    const GpuContext::Turn turn(now.context);
    shared = textures = std::make_shared<RoomTextures>(room, gains, now.most_bytes);
  }
  return std::make_unique<GpuRenderer>(now.context, std::move(textures));
}

void warn_of_gpu(const std::string& reason) {
  Chosen& now = chosen();
  const std::lock_guard lock(now.mutex);
  if (!std::exchange(now.warned, true)) spdlog::warn("{}; the processor renders views", reason);
}

}  // namespace raywalk
