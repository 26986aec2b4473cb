// Work on frames whose pictures and panoramas take much memory: only as many at once as fit.
#pragma once

#include <functional>

#include "core/files/lens_file.h"

namespace raywalk::calibrate {

// Memory of a frame in work: of its pictures (read, copied with a fourth channel), of a panorama of
// so many pixels (levels of two lenses, the result, its PNG), and of tables of its own.
double bytes_of_pictures(const DualFisheyeCamera& camera);
double bytes_of_panorama(double pixels);
double bytes_of_tables(double pixels);

// Number of frames of that many bytes each, at least 1 and at most thread_count().
int frames_at_once(double bytes_per_frame);

// Calls work(0) to work(count - 1) on that many threads, each taking the next frame. The first
// exception, or Interrupted, ends it after the frames that have begun.
void for_each_frame(int count, int at_once, const std::function<void(int)>& work);

}  // namespace raywalk::calibrate
