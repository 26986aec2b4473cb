// Images of one size in a graphics card's memory, as many as fit.
#pragma once

#include <GLES3/gl31.h>

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <utility>
#include <vector>

namespace raywalk {

// What an image is of: a line, and the index of its station or of its map there.
using ImageKey = std::pair<int, int>;

// Layers of an array texture, whose texels are read as they are. All is called during a Turn
// (gpu_context.h), and throws GpuError where the card fails.
class LayeredTexture {
 public:
  // `what` names the images in errors.
  LayeredTexture(const char* what, GLenum format, int width, int height, std::size_t layers);
  ~LayeredTexture();
  LayeredTexture(const LayeredTexture&) = delete;
  LayeredTexture& operator=(const LayeredTexture&) = delete;

  std::size_t layers() const { return keys_.size(); }
  // Uploads those of the images that are not there, no two alike, in place of those that were not
  // wanted for longest: `upload` puts one into a layer of the bound texture. Throws GpuError where
  // there are more than layers().
  using Upload = std::function<void(ImageKey image, int layer)>;
  void require(std::span<const ImageKey> images, const Upload& upload);
  // Of an image; -1 where it is not there.
  int layer(ImageKey image) const;
  void bind(GLuint unit) const;

 private:
  const char* what_;
  GLuint texture_ = 0;
  std::uint64_t turn_ = 0;
  std::vector<ImageKey> keys_;         // of each layer
  std::vector<std::uint64_t> wanted_;  // when each was wanted last
  std::map<ImageKey, int> at_;
};

}  // namespace raywalk
