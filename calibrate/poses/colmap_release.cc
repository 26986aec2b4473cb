#include "calibrate/poses/colmap_release.h"

#include <algorithm>
#include <array>

namespace raywalk::calibrate {
namespace {

// Of Debian 12 and 13. Their files are the same; since 3.9 the geometry of a pair has options of
// its own.
constexpr std::array kReleases{ColmapRelease{"3.8", "--SiftMatching.max_error"},
                               ColmapRelease{"3.10", "--TwoViewGeometry.max_error"}};

}  // namespace

std::optional<ColmapRelease> colmap_release_of(std::string_view version) {
  const auto found =
      std::find_if(kReleases.begin(), kReleases.end(), [&](const ColmapRelease& release) {
        const std::size_t length = release.number.size();
        return version.starts_with(release.number) &&
               (version.size() == length || version[length] == '.');
      });
  if (found == kReleases.end()) return std::nullopt;
  return *found;
}

}  // namespace raywalk::calibrate
