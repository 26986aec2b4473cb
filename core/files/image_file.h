// Reading and writing images, with errors that say what is wrong with the file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/files/gpano.h"
#include "core/geometry/sphere.h"

namespace raywalk {

enum class ImageFormat { kJpeg, kPng };

struct ImageHeader {
  ImageFormat format = ImageFormat::kJpeg;
  PanoramaSize size{};  // pixels, at least 1 x 1; any aspect ratio
  int bits_per_channel = 8;
  bool is_grey = false;    // one channel without alpha
  bool has_alpha = false;  // pixels may be transparent
  int orientation = 1;     // EXIF's, 1 to 8: how viewers turn the image; 1 (as stored) if not given
  bool is_cropped = false;                   // shows a part of a sphere, as its GPano tags state
  std::optional<StatedAttitude> attitude{};  // of its GPano tags
};

// The header of the image that starts with `bytes`, which may be cut off behind it. Throws Error
// naming `source`: empty, neither JPEG nor PNG, a header that is damaged or not all there.
ImageHeader parse_image_header(std::span<const std::byte> bytes, const std::string& source);

// An 8-bit colour panorama, CV_8UC3 in OpenCV's BGR order, width = 2 * height, in sRGB, also of a
// file whose ICC profile is another one. EXIF orientation is ignored. Throws Error naming the file:
// missing, empty, neither JPEG nor PNG, cut short, damaged as far as its checksums (PNG) or its
// decoder (JPEG) can tell, not 2:1, part of a sphere.
cv::Mat read_panorama(const std::filesystem::path& file);

// An 8-bit colour image of any aspect ratio, such as a fisheye frame; otherwise as read_panorama.
cv::Mat read_picture(const std::filesystem::path& file);

// A distance map: 16-bit grey PNG, CV_16UC1, millimetres along the ray, 0 = no surface. Throws
// Error as read_panorama, also if it is not 16-bit grey.
cv::Mat read_distance_map(const std::filesystem::path& file);

// A mask, CV_8UC1, 255 where it is valid and 0 where it is masked: an 8-bit grey image of any
// format, valid from 128 on, or from 1 on if there is nothing above; or a picture with an alpha
// channel, valid where it is opaque. Throws Error as read_panorama, also if its size is not `size`.
cv::Mat read_mask(const std::filesystem::path& file, PanoramaSize size);
// Throws the errors of read_mask that the header reveals, without decoding the image, also for an
// image that is not grey.
void require_mask(const std::filesystem::path& file, PanoramaSize size);

// From the image's header, without decoding it. Throws the errors of read_panorama, read_picture
// and read_distance_map that the header reveals.
ImageHeader panorama_header_of(const std::filesystem::path& file);
ImageHeader picture_header_of(const std::filesystem::path& file);
PanoramaSize distance_map_size_of(const std::filesystem::path& file);

// Collects the images of one run whose EXIF orientation asks viewers to turn or mirror them, for
// one warning. Raywalk uses pixels as they are stored: those of a lens have to stay where its
// calibration has them, and turning by 90 degrees makes no panorama.
class TurnedPictures {
 public:
  void add(const std::filesystem::path& file, int orientation);
  // Logs a warning that names the first one, its orientation and how many others there are; nothing
  // if there is none.
  void warn() const;

 private:
  std::filesystem::path first_{};
  int first_orientation_ = 1;
  int count_ = 0;
};

// Decodes a whole image file held in memory, to see whether it is intact, for capture, import and
// packing alike. Returns its header. Throws Error naming `source` if it is cut short, damaged or
// neither JPEG nor PNG.
ImageHeader require_intact_image(std::span<const std::byte> bytes, const std::string& source);

// The bytes of an image file; the format follows the extension of `file`: .png, .jpg, .webp or
// .tif. `quality` is that of JPEG and WebP, 1 to 100; without it 95. Throws UsageError for another
// extension, Error naming the file for an image that the format cannot hold.
std::vector<unsigned char> encode_image(const std::filesystem::path& file, const cv::Mat& image,
                                        std::optional<int> quality = {});

// Writes an image atomically (see atomic_output.h) as encode_image() does. Throws Error naming the
// file.
void write_image(const std::filesystem::path& file, const cv::Mat& image);

}  // namespace raywalk
