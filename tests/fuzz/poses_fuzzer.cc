// Any bytes are either poses of other programs, all finite, or rejected with a one-line Error.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/reconstruction/colmap_model.h"
#include "core/reconstruction/nerfstudio_file.h"
#include "tests/fuzz/expect.h"

namespace {

void require_finite(const raywalk::CameraPose& pose) {
  if (!pose.position_m.allFinite() || !pose.world_from_camera.allFinite()) std::abort();
}

template <typename Read>
void expect_poses(const Read& read) {
  try {
    read();
  } catch (const raywalk::Error& e) {
    raywalk::expect_one_line(e);
  }
}

void require_finite(const std::vector<raywalk::ColmapImage>& images) {
  for (const auto& image : images) require_finite(raywalk::camera_pose_of(image.pose, {}));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  expect_poses([&] { require_finite(raywalk::colmap_images_of_bytes(text, "images.bin")); });
  expect_poses([&] { require_finite(raywalk::colmap_images_of_text(text, "images.txt")); });
  expect_poses([&] {
    for (const auto& frame : raywalk::nerfstudio_of_text(text, "t.json"))
      require_finite(frame.pose);
  });
  return 0;
}
