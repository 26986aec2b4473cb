#include "calibrate/stitch/frames_at_once.h"

#include <algorithm>
#include <atomic>

#include "core/base/interrupt.h"
#include "core/base/parallel.h"

namespace raywalk::calibrate {
namespace {

// For all frames in work.
constexpr double kWorkBytes = 1.5e9;
constexpr double kBytesPerPicturePixel = 10.0;
constexpr double kBytesPerPanoramaPixel = 20.0;
// A position and a root in each lens, and what picks the lens.
constexpr double kBytesPerTablePixel = 29.0;

}  // namespace

double bytes_of_pictures(const DualFisheyeCamera& camera) {
  return kBytesPerPicturePixel * (camera.two_files ? 2.0 : 1.0) * camera.picture.width *
         camera.picture.height;
}

double bytes_of_panorama(double pixels) { return kBytesPerPanoramaPixel * pixels; }

double bytes_of_tables(double pixels) { return kBytesPerTablePixel * pixels; }

int frames_at_once(double bytes_per_frame) {
  return std::clamp(static_cast<int>(kWorkBytes / bytes_per_frame), 1, thread_count());
}

// Tasks that wait for memory could deadlock, as the thread that holds it may pick them up.
void for_each_frame(int count, int at_once, const std::function<void(int)>& work) {
  std::atomic<int> next = 0;
  parallel_for(0, at_once, 1, [&](int, int) {
    for (int i = next++; i < count; i = next++) {
      throw_if_interrupted();
      try {
        work(i);
      } catch (...) {
        next = count;  // the others stop after their frame
        throw;
      }
    }
  });
}

}  // namespace raywalk::calibrate
