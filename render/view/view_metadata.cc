#include "render/view/view_metadata.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/files/exif.h"
#include "core/geometry/sphere.h"

namespace raywalk::render {
namespace {

constexpr double kFrameWidth_mm = 36.0;
constexpr double kMostShort = 65535.0;  // FocalLengthIn35mmFilm is a SHORT
constexpr std::uint16_t kCentimetres = 3;

// --- XMP ----------------------------------------------------------------------------------------

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

// Attributes of an XMP packet, by name.
using Attributes = std::vector<std::pair<std::string, std::string>>;

void describe_panorama(cv::Size size, const Attitude& attitude, Attributes* xmp) {
  const std::string width = std::to_string(size.width), height = std::to_string(size.height);
  xmp->insert(xmp->end(), {{"GPano:UsePanoramaViewer", "True"},
                           {"GPano:CaptureSoftware", "Raywalk"},
                           {"GPano:StitchingSoftware", "Raywalk"},
                           {"GPano:ProjectionType", "equirectangular"},
                           {"GPano:FullPanoWidthPixels", width},
                           {"GPano:FullPanoHeightPixels", height},
                           {"GPano:CroppedAreaImageWidthPixels", width},
                           {"GPano:CroppedAreaImageHeightPixels", height},
                           {"GPano:CroppedAreaLeftPixels", "0"},
                           {"GPano:CroppedAreaTopPixels", "0"},
                           {"GPano:PoseHeadingDegrees", heading_text(attitude.yaw_rad)},
                           {"GPano:PosePitchDegrees", degrees_text(attitude.pitch_rad)},
                           {"GPano:PoseRollDegrees", degrees_text(attitude.roll_rad)}});
}

// XMP's simplest form (ISO 16684-1, 7.9.2.2): every property an attribute. No value needs escapes.
std::string xmp_packet(cv::Size size, const ViewDescription& view) {
  const Attitude attitude = usual_attitude(view.frame);
  Attributes xmp;
  if (view.frame.stereo == Stereo::kOds) {
    xmp = {{"raywalk:Stereo", "top-bottom"},
           {"raywalk:EyesApart_mm", number(ipd_mm_of(view.frame))}};
  } else if (view.frame.fov_deg == 0.0) {
    describe_panorama(size, attitude, &xmp);
  }
  xmp.insert(xmp.end(), {{"raywalk:X_m", number(view.x_m)},
                         {"raywalk:Y_m", number(view.y_m)},
                         {"raywalk:Z_m", number(view.z_m)},
                         {"raywalk:YawDeg", degrees_text(attitude.yaw_rad)},
                         {"raywalk:PitchDeg", degrees_text(attitude.pitch_rad)},
                         {"raywalk:RollDeg", degrees_text(attitude.roll_rad)}});
  std::string text = fmt::format(
      "<?xpacket begin=\"\xEF\xBB\xBF\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>\n"
      "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n"
      "<rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n"
      "<rdf:Description rdf:about=\"\" "
      "xmlns:GPano=\"http://ns.google.com/photos/1.0/panorama/\" xmlns:raywalk=\"{}\"",
      kRaywalkNamespace);
  for (const auto& [name, value] : xmp) text += fmt::format("\n  {}=\"{}\"", name, value);
  return text + "/>\n</rdf:RDF>\n</x:xmpmeta>\n<?xpacket end=\"r\"?>";
}

// --- Exif ---------------------------------------------------------------------------------------

TiffEntry thousandths(int tag, double value) {
  return rational_entry(tag, static_cast<std::uint32_t>(std::lround(1000.0 * value)), 1000);
}

// Entries of the image, and of its exposure.
using ImageEntries = std::vector<TiffEntry>;
using ExposureEntries = std::vector<TiffEntry>;

ImageEntries image_entries() { return {ascii_entry(EXIF_TAG_SOFTWARE, "Raywalk")}; }

ExposureEntries exposure_entries(cv::Size size, double fov_deg) {
  if (fov_deg == 0.0) return {};
  const double focal_mm = 0.5 * kFrameWidth_mm / std::tan(0.5 * radians_from_degrees(fov_deg));
  const double per_cm = 10.0 * size.width / kFrameWidth_mm;
  ExposureEntries entries = {thousandths(EXIF_TAG_FOCAL_LENGTH, focal_mm),
                             thousandths(EXIF_TAG_FOCAL_PLANE_X_RESOLUTION, per_cm),
                             thousandths(EXIF_TAG_FOCAL_PLANE_Y_RESOLUTION, per_cm),
                             short_entry(EXIF_TAG_FOCAL_PLANE_RESOLUTION_UNIT, kCentimetres)};
  if (focal_mm <= kMostShort) {
    entries.push_back(short_entry(EXIF_TAG_FOCAL_LENGTH_IN_35MM_FILM,
                                  static_cast<std::uint16_t>(std::max(1L, std::lround(focal_mm)))));
  }
  return entries;
}

// --- Files --------------------------------------------------------------------------------------

std::string big_endian(std::uint64_t value) {
  const std::string text = little_endian(value, 4);
  return {text.rbegin(), text.rend()};
}

// A chunk with its checksum (W3C PNG, 5.3).
std::string png_chunk(const std::string& type, const std::string& data) {
  const std::string body = type + data;
  const auto sum =
      ::crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()));
  return big_endian(data.size()) + body + big_endian(sum);
}

// Behind the first chunk, IHDR.
std::string with_metadata_png(const std::string& png, const std::string& xmp,
                              const std::string& exif) {
  constexpr std::size_t kHeaderEnd = 33;
  const std::string text = std::string("XML:com.adobe.xmp\0\0\0\0\0", 22) + xmp;
  return png.substr(0, kHeaderEnd) + png_chunk("iTXt", text) + png_chunk("eXIf", exif) +
         png.substr(kHeaderEnd);
}

// A chunk (developers.google.com/speed/webp/docs/riff_container).
std::string webp_chunk(const std::string& type, std::string data) {
  const std::string size = little_endian(data.size(), 4);
  if (data.size() % 2 != 0) data.push_back('\0');
  return type + size + data;
}

// OpenCV writes the simple form, whose one chunk is the image; the extended form begins with a
// chunk of flags and size.
std::string with_metadata_webp(const std::string& webp, cv::Size size, const std::string& xmp,
                               const std::string& exif) {
  constexpr std::size_t kFileHeader = 12;
  constexpr std::uint64_t kHasExif = 0x08, kHasXmp = 0x04;
  const std::string form = little_endian(kHasExif | kHasXmp, 4) + little_endian(size.width - 1, 3) +
                           little_endian(size.height - 1, 3);
  const std::string chunks = "WEBP" + webp_chunk("VP8X", form) + webp.substr(kFileHeader) +
                             webp_chunk("EXIF", exif) + webp_chunk("XMP ", xmp);
  return "RIFF" + little_endian(chunks.size(), 4) + chunks;
}

// With a new directory at the end, of the entries that OpenCV wrote, whose values stay in place,
// and of further ones.
std::string with_metadata_tiff(std::string tiff, const std::string& xmp,
                               const ExposureEntries& exposure) {
  constexpr int kXmpTag = 700;  // XMP specification, part 3
  const auto number = [&](std::size_t at, int bytes) {
    std::uint64_t value = 0;
    for (int i = bytes; i-- > 0;) value = value << 8 | static_cast<std::uint8_t>(tiff.at(at + i));
    return value;
  };
  ImageEntries entries = image_entries();
  const std::size_t directory = number(4, 4);
  for (std::size_t i = 0; i < number(directory, 2); ++i) {
    const std::size_t entry = directory + 2 + 12 * i;
    entries.push_back({static_cast<std::uint16_t>(number(entry, 2)),
                       static_cast<std::uint16_t>(number(entry + 2, 2)),
                       static_cast<std::uint32_t>(number(entry + 4, 4)),
                       tiff.substr(entry + 8, 4)});
  }
  if (tiff.size() % 2 != 0) tiff.push_back('\0');
  if (!exposure.empty()) {
    entries.push_back(
        long_entry(EXIF_TAG_EXIF_IFD_POINTER, static_cast<std::uint32_t>(tiff.size())));
    tiff += tiff_directory(exposure, tiff.size());
  }
  entries.push_back(bytes_entry(kXmpTag, xmp));
  tiff.replace(4, 4, little_endian(tiff.size(), 4));
  return tiff + tiff_directory(std::move(entries), tiff.size());
}

}  // namespace

std::string with_metadata(const std::string& picture, cv::Size size, const ViewDescription& view) {
  const std::string xmp = xmp_packet(size, view);
  const ExposureEntries exposure = exposure_entries(size, view.frame.fov_deg);
  if (picture.starts_with("II")) return with_metadata_tiff(picture, xmp, exposure);
  const std::string exif = exif_block(image_entries(), exposure);
  if (picture.starts_with("RIFF")) return with_metadata_webp(picture, size, xmp, exif);
  if (picture.starts_with("\x89PNG")) return with_metadata_png(picture, xmp, exif);
  const std::string identifier("http://ns.adobe.com/xap/1.0/\0", 29);
  return with_app1(with_app1(picture, identifier, xmp), kExifIdentifier, exif);
}

}  // namespace raywalk::render
