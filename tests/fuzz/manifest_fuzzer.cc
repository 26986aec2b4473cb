// Any text is either a manifest that survives a round trip, or rejected with a one-line Error.
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>

#include "core/base/error.h"
#include "core/room/room.h"
#include "tests/fuzz/expect.h"

namespace {

std::optional<raywalk::RoomManifest> manifest_of(const std::string& text) {
  try {
    return raywalk::manifest_from_json(text, "manifest.json");
  } catch (const raywalk::Error& e) {
    raywalk::expect_one_line(e);
    return std::nullopt;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto manifest = manifest_of({reinterpret_cast<const char*>(data), size});
  if (!manifest) return 0;
  const std::string text = raywalk::manifest_to_json(*manifest);
  const auto again = manifest_of(text);
  if (!again || raywalk::manifest_to_json(*again) != text) std::abort();
  return 0;
}
