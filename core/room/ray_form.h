// How the rays of a line are stored: as they are, or compressed in tiles (tiled_rays.h).
#pragma once

#include <cstdint>
#include <string>

namespace raywalk {

struct RayForm {
  enum class Kind {
    kRaw,       // mapped into memory
    kLossless,  // decoded to what was captured
    kJpeg,      // decoded to nearly that, at a quality of 1 to 100
  };
  Kind kind = Kind::kRaw;
  int jpeg_quality = 0;  // of kJpeg only

  bool compressed() const { return kind != Kind::kRaw; }
  friend bool operator==(const RayForm&, const RayForm&) = default;
};

// "none", "lossless" or "jpeg:Q" with Q from 1 to 100, as in --compress and in files. Throws
// UsageError on anything else.
RayForm ray_form_from_name(const std::string& name);
std::string name_of(const RayForm& form);

// What rays of so many bytes take at most in this form, unless a scene is all noise.
std::uint64_t estimated_bytes(const RayForm& form, std::uint64_t raw_bytes);

}  // namespace raywalk
