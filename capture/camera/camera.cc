#include "capture/camera/camera.h"

#include "core/base/error.h"

namespace raywalk::capture {
namespace {

[[noreturn]] void refuse_film(const Camera& camera) {
  throw UsageError(camera.description() +
                   " cannot film under the program's control; set run.mode to stations, or film "
                   "with a gpio camera");
}

}  // namespace

void Camera::start_film() { refuse_film(*this); }

void Camera::stop_film() { refuse_film(*this); }

}  // namespace raywalk::capture
