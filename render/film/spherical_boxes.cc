#include "render/film/spherical_boxes.h"

#include <cstdint>

#include "core/base/error.h"

namespace raywalk::render {
namespace {

constexpr const char* kSoftware = "Raywalk";

// ffcc8263-f855-4a93-8814-587a02521fdd, of V1.
constexpr std::string_view kUuid =
    "\xff\xcc\x82\x63\xf8\x55\x4a\x93\x88\x14\x58\x7a\x02\x52\x1f\xdd";

// A "full box": version and flags, both 0, come before the rest.
FilmBox full_box(const char* type, const std::string& payload) {
  return {.type = type, .payload = std::string(4, '\0') + payload};
}

char stereo_code(StereoMode stereo) { return stereo == StereoMode::kTopBottom ? '\1' : '\0'; }

FilmBox st3d(StereoMode stereo) { return full_box("st3d", std::string(1, stereo_code(stereo))); }

// Neither turned (prhd: yaw, pitch and roll 0) nor cropped (equi: nothing is missing on four
// sides).
FilmBox sv3d() {
  FilmBox projection{.type = "proj"};
  projection.children = {full_box("prhd", std::string(12, '\0')),
                         full_box("equi", std::string(16, '\0'))};
  FilmBox box{.type = "sv3d"};
  box.children = {full_box("svhd", std::string(kSoftware) + '\0'), projection};
  return box;
}

FilmBox spherical_v1(StereoMode stereo) {
  std::string xml =
      "<?xml version=\"1.0\"?>"
      "<rdf:SphericalVideo xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\" "
      "xmlns:GSpherical=\"http://ns.google.com/videos/1.0/spherical/\">"
      "<GSpherical:Spherical>true</GSpherical:Spherical>"
      "<GSpherical:Stitched>true</GSpherical:Stitched>"
      "<GSpherical:StitchingSoftware>";
  xml += kSoftware;
  xml +=
      "</GSpherical:StitchingSoftware>"
      "<GSpherical:ProjectionType>equirectangular</GSpherical:ProjectionType>";
  if (stereo == StereoMode::kTopBottom) {
    xml += "<GSpherical:StereoMode>top-bottom</GSpherical:StereoMode>";
  }
  xml += "</rdf:SphericalVideo>";
  return {.type = "uuid", .payload = std::string(kUuid) + xml};
}

}  // namespace

void add_spherical_metadata(StereoMode stereo, const std::string& source, FilmBox* movie) {
  bool added = false;
  for (FilmBox& track : movie->children) {
    FilmBox* entry = track.type == "trak" ? visual_sample_entry(track) : nullptr;
    if (entry == nullptr) continue;
    entry->children.push_back(st3d(stereo));
    entry->children.push_back(sv3d());
    track.children.push_back(spherical_v1(stereo));
    added = true;
  }
  if (!added) throw Error(source + ": the film has no track of pictures");
}

SphericalMetadata spherical_metadata_of(const FilmBox& track) {
  const FilmBox* entry = visual_sample_entry(track);
  SphericalMetadata metadata;
  if (entry == nullptr) return metadata;
  // Boxes below a sample entry are not parsed.
  if (const FilmBox* spherical = entry->child("sv3d")) {
    metadata.is_equirectangular = spherical->payload.find("equi") != std::string::npos;
  }
  const FilmBox* stereo = entry->child("st3d");
  if (stereo != nullptr && stereo->payload.size() > 4 &&
      stereo->payload[4] == stereo_code(StereoMode::kTopBottom)) {
    metadata.stereo = StereoMode::kTopBottom;
  }
  return metadata;
}

}  // namespace raywalk::render
