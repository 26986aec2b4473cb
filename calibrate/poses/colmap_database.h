// Reads images and verified matches from COLMAP's database (colmap.github.io/database.html).
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/reconstruction/panorama_faces.h"

namespace raywalk::calibrate {

struct DatabaseImage {
  std::uint32_t id = 0;
  std::uint32_t camera = 0;  // id
  int features = 0;
};

// By the image's name. Throws Error naming the file if it is missing, not a database or damaged.
std::map<std::string, DatabaseImage> read_database_images(const std::filesystem::path& database);

// Two images and the pixels of their geometrically verified matches.
struct VerifiedPair {
  std::uint32_t first = 0;  // ids
  std::uint32_t second = 0;
  std::vector<FacePixel> in_first{};
  std::vector<FacePixel> in_second{};  // of the same size
};

// Pairs with at least one verified match, in the order of the database. Throws Error naming the
// file if it is missing, not a database or damaged.
std::vector<VerifiedPair> read_verified_pairs(const std::filesystem::path& database);

}  // namespace raywalk::calibrate
