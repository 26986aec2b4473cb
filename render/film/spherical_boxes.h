// What tells players that a film is a panorama: Google's "Spherical Video V2 RFC" (boxes st3d and
// sv3d in the sample entry) and the older "Spherical Video RFC" (XMP in a uuid box of the track).
// https://github.com/google/spatial-media/blob/master/docs
#pragma once

#include "render/film/film_boxes.h"

namespace raywalk::render {

// Which picture of a frame each eye sees.
enum class StereoMode { kMono, kTopBottom };  // top: the left eye

// Adds the metadata of an equirectangular film of the whole sphere, whose middle looks forward, to
// every track of pictures in a "moov" box. Throws Error naming `source` where there is no such
// track.
void add_spherical_metadata(StereoMode stereo, const std::string& source, FilmBox* movie);

// What V2 says of a track's pictures.
struct SphericalMetadata {
  bool is_equirectangular = false;
  StereoMode stereo = StereoMode::kMono;
};
SphericalMetadata spherical_metadata_of(const FilmBox& track);

}  // namespace raywalk::render
