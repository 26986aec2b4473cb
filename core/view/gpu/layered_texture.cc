#include "core/view/gpu/layered_texture.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/view/gpu/gpu_context.h"

namespace raywalk {
namespace {

constexpr ImageKey kNone{-1, -1};

}  // namespace

LayeredTexture::LayeredTexture(const char* what, GLenum format, int width, int height,
                               std::size_t layers)
    : what_(what) {
  GLint most_layers = 0, most_pixels = 0;
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most_layers);
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most_pixels);
  layers = std::min(layers, static_cast<std::size_t>(most_layers));
  if (std::max(width, height) > most_pixels || layers == 0) {
    throw GpuError(fmt::format("{} of {} x {} pixels are too large for the card or for --gpu-mb",
                               what, height, width));
  }
  glGenTextures(1, &texture_);
  bind(0);
  glTexStorage3D(GL_TEXTURE_2D_ARRAY, 1, format, width, height, static_cast<GLsizei>(layers));
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  try {
    check_gpu(what);
  } catch (const GpuError&) {
    glDeleteTextures(1, &texture_);
    throw;
  }
  keys_.assign(layers, kNone);
  wanted_.assign(layers, 0);
}

LayeredTexture::~LayeredTexture() { glDeleteTextures(1, &texture_); }

int LayeredTexture::layer(ImageKey image) const {
  const auto found = at_.find(image);
  return found == at_.end() ? -1 : found->second;
}

void LayeredTexture::bind(GLuint unit) const {
  glActiveTexture(GL_TEXTURE0 + unit);
  glBindTexture(GL_TEXTURE_2D_ARRAY, texture_);
}

void LayeredTexture::require(std::span<const ImageKey> images, const Upload& upload) {
  if (images.size() > layers()) {
    throw GpuError(fmt::format("too little memory of the card for {}", what_));
  }
  ++turn_;
  std::vector<ImageKey> missing;
  for (const ImageKey& image : images) {
    const int there = layer(image);
    if (there < 0) {
      missing.push_back(image);
    } else {
      wanted_[static_cast<std::size_t>(there)] = turn_;
    }
  }
  for (const ImageKey& image : missing) {
    const auto oldest = std::ranges::min_element(wanted_) - wanted_.begin();
    const auto layer = static_cast<std::size_t>(oldest);
    at_.erase(keys_[layer]);
    keys_[layer] = kNone;
    bind(0);
    upload(image, static_cast<int>(layer));
    check_gpu(what_);
    keys_[layer] = image;
    wanted_[layer] = turn_;
    at_[image] = static_cast<int>(layer);
  }
}

}  // namespace raywalk
