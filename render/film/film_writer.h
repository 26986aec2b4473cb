// Writes a film: frames in, a complete file out, or none.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "core/files/atomic_output.h"
#include "render/film/film_encoder.h"
#include "render/film/film_file.h"

namespace raywalk::render {

// Throws Error where a film cannot be written there: something is there already and `replace` does
// not allow it, or it is not a film of Raywalk's; the folder is not writable.
void require_writable_film(const std::filesystem::path& file, bool replace);

// Throws UsageError for frames of an odd width or height.
void require_film_size(cv::Size size);

class FilmWriter {
 public:
  // `stereo`: the film is a panorama of the whole sphere and says so; without it, it is flat.
  // `shape` is that of the frames; both sides are even. Throws UsageError, Error as FilmEncoder
  // does.
  FilmWriter(const FilmSettings& settings, const FilmShape& shape, std::optional<StereoMode> stereo,
             const std::filesystem::path& file);

  // As FilmEncoder::add().
  void add(const cv::Mat& frame) { encoder_.add(frame); }
  // Completes the film, which has to have all of its frames, reads it again to see that every frame
  // and what it says of itself is there, and gives it its name. Throws Error, Interrupted; then
  // nothing is left.
  void finish();

 private:
  std::filesystem::path target_;
  FilmShape shape_;
  std::optional<StereoMode> stereo_;
  AtomicFile film_;
  FilmEncoder encoder_;
};

}  // namespace raywalk::render
