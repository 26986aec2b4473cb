#include "render/picture/view_metadata.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <exiv2/exiv2.hpp>

#include "core/base/error.h"
#include "core/geometry/sphere.h"

namespace raywalk::render {
namespace {

constexpr double kFilmWidth_mm = 36.0;
constexpr double kMostShort = 65535.0;  // FocalLengthIn35mmFilm is a SHORT
constexpr std::uint16_t kCentimetres = 3;

void register_namespaces() {
  [[maybe_unused]] static const bool once = [] {
    Exiv2::LogMsg::setLevel(Exiv2::LogMsg::mute);
    Exiv2::XmpParser::initialize();
    Exiv2::XmpProperties::registerNs("http://ns.google.com/photos/1.0/panorama/", "GPano");
    Exiv2::XmpProperties::registerNs(kRaywalkNamespace, "raywalk");
    return true;
  }();
}

// With as many decimals as tell neighbouring views apart, and no "-0".
std::string number(double value) { return fmt::format("{:.7g}", value + 0.0); }

// The same direction and tilt, with the pitch in [-90, 90] degrees.
Attitude usual_attitude(const ViewFrame& frame) {
  return attitude_from_world_from_camera(
      world_from_camera({radians_from_degrees(frame.yaw_deg), radians_from_degrees(frame.pitch_deg),
                         radians_from_degrees(frame.roll_deg)}));
}

// In [0, 360) also after rounding.
std::string heading_text(double yaw_rad) {
  const double heading = std::round(degrees_from_radians(yaw_rad) * 1e6) / 1e6;
  return number(heading < 0.0 ? heading + 360.0 : heading);
}

std::string degrees_text(double angle_rad) {
  return number(std::round(degrees_from_radians(angle_rad) * 1e6) / 1e6);
}

void describe_panorama(cv::Size size, const Attitude& attitude, Exiv2::XmpData* xmp) {
  const std::string width = std::to_string(size.width), height = std::to_string(size.height);
  const auto set = [&](const char* key, const std::string& value) {
    (*xmp)[std::string("Xmp.GPano.") + key] = value;
  };
  set("UsePanoramaViewer", "True");
  set("CaptureSoftware", "Raywalk");
  set("StitchingSoftware", "Raywalk");
  set("ProjectionType", "equirectangular");
  set("FullPanoWidthPixels", width);
  set("FullPanoHeightPixels", height);
  set("CroppedAreaImageWidthPixels", width);
  set("CroppedAreaImageHeightPixels", height);
  set("CroppedAreaLeftPixels", "0");
  set("CroppedAreaTopPixels", "0");
  set("PoseHeadingDegrees", heading_text(attitude.yaw_rad));
  set("PosePitchDegrees", degrees_text(attitude.pitch_rad));
  set("PoseRollDegrees", degrees_text(attitude.roll_rad));
}

void describe_stereo(const ViewFrame& frame, Exiv2::XmpData* xmp) {
  (*xmp)["Xmp.raywalk.Stereo"] = std::string("top-bottom");
  (*xmp)["Xmp.raywalk.EyesApart_mm"] = number(ipd_mm_of(frame));
}

Exiv2::URational thousandths(double value) {
  return {static_cast<std::uint32_t>(std::lround(1000.0 * value)), 1000};
}

void describe_flat(cv::Size size, double fov_deg, Exiv2::ExifData* exif) {
  const double focal_mm = 0.5 * kFilmWidth_mm / std::tan(0.5 * radians_from_degrees(fov_deg));
  (*exif)["Exif.Photo.FocalLength"] = thousandths(focal_mm);
  const Exiv2::URational per_cm = thousandths(10.0 * size.width / kFilmWidth_mm);
  (*exif)["Exif.Photo.FocalPlaneXResolution"] = per_cm;
  (*exif)["Exif.Photo.FocalPlaneYResolution"] = per_cm;
  (*exif)["Exif.Photo.FocalPlaneResolutionUnit"] = kCentimetres;
  if (focal_mm > kMostShort) return;
  (*exif)["Exif.Photo.FocalLengthIn35mmFilm"] =
      static_cast<std::uint16_t>(std::max(1L, std::lround(focal_mm)));
}

void describe_pose(const ViewDescription& view, const Attitude& attitude, Exiv2::XmpData* xmp) {
  const auto set = [&](const char* key, const std::string& value) {
    (*xmp)[std::string("Xmp.raywalk.") + key] = value;
  };
  set("X_m", number(view.x_m));
  set("Y_m", number(view.y_m));
  set("Z_m", number(view.z_m));
  set("YawDeg", degrees_text(attitude.yaw_rad));
  set("PitchDeg", degrees_text(attitude.pitch_rad));
  set("RollDeg", degrees_text(attitude.roll_rad));
}

std::vector<unsigned char> content_of(Exiv2::BasicIo& io) {
  std::vector<unsigned char> bytes(io.size());
  io.open();
  io.seek(0, Exiv2::BasicIo::beg);
  const auto count = io.read(bytes.data(), io.size());
  io.close();
  bytes.resize(static_cast<std::size_t>(count));
  return bytes;
}

}  // namespace

std::vector<unsigned char> with_metadata(const std::vector<unsigned char>& picture, cv::Size size,
                                         const ViewDescription& view, const std::string& name) {
  register_namespaces();
  try {
    const auto image = Exiv2::ImageFactory::open(picture.data(), picture.size());
    image->readMetadata();  // of TIFF these are also what describes the pixels
    const Attitude attitude = usual_attitude(view.frame);
    image->exifData()["Exif.Image.Software"] = std::string("Raywalk");
    if (view.frame.stereo == Stereo::kOds) {
      describe_stereo(view.frame, &image->xmpData());
    } else if (view.frame.fov_deg == 0.0) {
      describe_panorama(size, attitude, &image->xmpData());
    } else {
      describe_flat(size, view.frame.fov_deg, &image->exifData());
    }
    describe_pose(view, attitude, &image->xmpData());
    image->writeMetadata();
    return content_of(image->io());
  } catch (const Exiv2::Error& e) {
    throw Error(name + ": the metadata cannot be added (" + one_line(e.what()) + ")");
  }
}

}  // namespace raywalk::render
