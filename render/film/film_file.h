// A film as a file: completes what an encoder has written, and reads what a film holds.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "render/film/spherical_boxes.h"

namespace raywalk::render {

// What is written into every film, to know it again.
inline constexpr const char* kFilmComment = "made by raywalk-render path";

struct FilmFacts {
  std::int64_t frames = 0;
  int width = 0;
  int height = 0;
  std::optional<SphericalMetadata> spherical{};  // none: flat
  bool by_raywalk = false;
};

// Reads the description of a film, an MP4 or QuickTime file with one track of pictures. Throws
// Error naming the file: missing, not a film, cut short, damaged.
FilmFacts read_film(const std::filesystem::path& file);

// Copies an encoder's film to `to`, which must not exist, with its description (moov) before the
// frames, so that players begin before they have read all of it. With `stereo`, the metadata of a
// panorama is added; without it, the film is flat. `name` is what messages call the film. Throws
// Error (damaged, disk full), Interrupted.
void complete_film(const std::filesystem::path& encoded, std::optional<StereoMode> stereo,
                   const std::filesystem::path& to, const std::string& name);

}  // namespace raywalk::render
