// Reading and writing images, with errors that say what is wrong with the file.
#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/sphere.h"

namespace raywalk {

// An 8-bit colour panorama, CV_8UC3 in OpenCV's BGR order, width = 2 * height. EXIF orientation is
// ignored. Throws Error naming the file: missing, empty, not an image, truncated (JPEG without its
// end marker, PNG that stops early), damaged as far as its decoder can tell, not 2:1.
cv::Mat read_panorama(const std::filesystem::path& file);

// An 8-bit colour image of any aspect ratio, such as a fisheye frame; otherwise as read_panorama.
cv::Mat read_picture(const std::filesystem::path& file);

// A distance map: 16-bit grey PNG, CV_16UC1, millimetres along the ray, 0 = no surface. Throws
// Error as read_panorama, also if it is not 16-bit grey.
cv::Mat read_distance_map(const std::filesystem::path& file);

// A mask: an 8-bit grey image, CV_8UC1, any format. Throws Error as read_panorama, also if its size
// is not `size`.
cv::Mat read_mask(const std::filesystem::path& file, PanoramaSize size);
// Throws the errors of read_mask that the header reveals, without decoding the image.
void require_mask(const std::filesystem::path& file, PanoramaSize size);

// What an image's header tells.
struct PictureHeader {
  PanoramaSize size{};
  int orientation = 1;  // EXIF's, 1 to 8, for TurnedPictures (turned_pictures.h)
};

// From the image's header, without decoding it. Throws the errors of read_panorama that the
// header reveals.
PictureHeader panorama_header_of(const std::filesystem::path& file);
PanoramaSize panorama_size_of(const std::filesystem::path& file);
// The same for an image of any aspect ratio.
PictureHeader picture_header_of(const std::filesystem::path& file);
PanoramaSize picture_size_of(const std::filesystem::path& file);

// Decodes a whole image file held in memory, to see whether it is intact. Throws Error naming
// `source` if it is truncated, damaged or neither JPEG nor PNG.
void require_intact_image(std::string bytes, const std::string& source);

// The bytes of an image file; the format follows the extension of `file`: .png, .jpg, .webp or
// .tif. `quality` is that of JPEG and WebP, 1 to 100; without it 95. Throws UsageError for another
// extension, Error naming the file for a picture that the format cannot hold.
std::vector<unsigned char> encode_image(const std::filesystem::path& file, const cv::Mat& image,
                                        std::optional<int> quality = {});

// Writes an image atomically (see atomic_output.h) as encode_image() does. Throws Error naming the
// file.
void write_image(const std::filesystem::path& file, const cv::Mat& image);

}  // namespace raywalk
