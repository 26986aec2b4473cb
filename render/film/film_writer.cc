#include "render/film/film_writer.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/files/output_folder.h"

namespace raywalk::render {
namespace {

namespace fs = std::filesystem;

FilmShape even(const FilmShape& shape) {
  require_film_size(shape.size);
  return shape;
}

bool is_film_of_raywalk(const fs::path& file) {
  try {
    return read_film(file).by_raywalk;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

void require_writable_film(const fs::path& file, bool replace) {
  if (!replace) require_absent(file, "--video");
  std::error_code none;
  if (fs::exists(file, none) && !is_film_of_raywalk(file)) {
    throw Error(file.string() + " is not a film of Raywalk's, so --force does not replace it");
  }
  const AtomicFile probe(file);
}

void require_film_size(cv::Size size) {
  if (size.width % 2 == 0 && size.height % 2 == 0) return;
  throw UsageError(
      fmt::format("a film of {}x{} pixels is not possible: give --size with two even "
                  "numbers",
                  size.width, size.height));
}

FilmWriter::FilmWriter(const FilmSettings& settings, const FilmShape& shape,
                       std::optional<StereoMode> stereo, const fs::path& file)
    : target_(file),
      shape_(even(shape)),
      stereo_(stereo),
      film_(file),
      encoder_(settings, shape, film_.temporary_path(), file.string()) {}

void FilmWriter::finish() {
  encoder_.finish();
  if (stereo_) set_spherical(film_.temporary_path(), *stereo_, target_.string());
  const FilmFacts written = read_film(film_.temporary_path());
  const cv::Size size = shape_.size;
  if (written.frames != shape_.frames || written.width != size.width ||
      written.height != size.height || written.stereo != stereo_) {
    throw Error(fmt::format(
        "cannot write {}: read again, the film has {} frames of {}x{}, not {} of {}x{}; is the "
        "disk full?",
        target_.string(), written.frames, written.width, written.height, shape_.frames, size.width,
        size.height));
  }
  film_.commit();
}

}  // namespace raywalk::render
