#include "capture/camera/video_device.h"

#include <stdexcept>

namespace raywalk::capture {

std::string name_of(VideoControl control) {
  switch (control) {
    case VideoControl::kExposureMode:
      return "exposure_mode";
    case VideoControl::kExposure:
      return "exposure_100us";
    case VideoControl::kAutoGain:
      return "auto_gain";
    case VideoControl::kGain:
      return "gain";
    case VideoControl::kAutoWhiteBalance:
      return "auto_white_balance";
    case VideoControl::kWhiteBalance:
      return "white_balance_k";
  }
  throw std::logic_error("unknown video control");
}

}  // namespace raywalk::capture
