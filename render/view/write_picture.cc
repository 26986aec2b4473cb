#include "render/view/write_picture.h"

#include "core/files/atomic_output.h"
#include "core/files/image_file.h"

namespace raywalk::render {

void write_picture(const std::filesystem::path& file, const cv::Mat& image,
                   const PictureFormat& format, const ViewDescription& view) {
  const std::vector<unsigned char> pixels = encode_image(file, image, format.quality);
  write_file_atomically(file, with_metadata({pixels.begin(), pixels.end()}, image.size(), view));
}

}  // namespace raywalk::render
