#include "calibrate/poses/colmap_database.h"

#include <fmt/format.h>

#include <cstring>
#include <span>
#include <unordered_map>

#include "core/base/error.h"
#include "core/files/sqlite_connection.h"

namespace raywalk::calibrate {
namespace {

// COLMAP's id of a pair: first * (2^31 - 1) + second.
constexpr std::int64_t kPairFactor = 2147483647;

// A matrix of a table's columns rows, cols, data; row-major.
template <typename Number>
std::vector<Number> matrix_at(const SqliteStatement& statement, int first_column,
                              const std::filesystem::path& file) {
  const std::int64_t rows = statement.integer(first_column);
  const std::int64_t columns = statement.integer(first_column + 1);
  const std::span<const std::byte> bytes = statement.blob(first_column + 2);
  const auto count = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  if (rows < 0 || columns < 2 || columns > 6 || bytes.size() != count * sizeof(Number)) {
    throw Error(
        fmt::format("{}: damaged; delete its directory and run poses again", file.string()));
  }
  std::vector<Number> numbers(count);
  if (!numbers.empty()) std::memcpy(numbers.data(), bytes.data(), bytes.size());
  return numbers;
}

using FeaturePixels = std::unordered_map<std::uint32_t, std::vector<FacePixel>>;

FeaturePixels read_features(SqliteConnection* connection, const std::filesystem::path& file) {
  FeaturePixels features;
  SqliteStatement statement(connection, "SELECT image_id, rows, cols, data FROM keypoints");
  while (statement.step()) {
    const std::vector<float> numbers = matrix_at<float>(statement, 1, file);
    const auto columns = static_cast<std::size_t>(statement.integer(2));
    std::vector<FacePixel>& pixels = features[static_cast<std::uint32_t>(statement.integer(0))];
    for (std::size_t at = 0; at < numbers.size(); at += columns) {
      pixels.push_back({numbers[at], numbers[at + 1]});
    }
  }
  return features;
}

const std::vector<FacePixel>& features_of(const FeaturePixels& features, std::uint32_t image) {
  static const std::vector<FacePixel> kNone;
  const auto found = features.find(image);
  return found == features.end() ? kNone : found->second;
}

}  // namespace

std::map<std::string, DatabaseImage> read_database_images(const std::filesystem::path& database) {
  SqliteConnection connection(database, SqliteAccess::kReadOnly);
  SqliteStatement statement(&connection,
                            "SELECT images.name, images.image_id, images.camera_id, "
                            "COALESCE(keypoints.rows, 0) FROM images LEFT JOIN keypoints "
                            "ON keypoints.image_id = images.image_id");
  std::map<std::string, DatabaseImage> images;
  while (statement.step()) {
    images[statement.text(0)] = {static_cast<std::uint32_t>(statement.integer(1)),
                                 static_cast<std::uint32_t>(statement.integer(2)),
                                 static_cast<int>(statement.integer(3))};
  }
  return images;
}

std::vector<VerifiedPair> read_verified_pairs(const std::filesystem::path& database) {
  SqliteConnection connection(database, SqliteAccess::kReadOnly);
  const FeaturePixels features = read_features(&connection, database);
  SqliteStatement statement(
      &connection, "SELECT pair_id, rows, cols, data FROM two_view_geometries WHERE rows > 0");
  std::vector<VerifiedPair> pairs;
  while (statement.step()) {
    const std::int64_t number = statement.integer(0);
    VerifiedPair pair;
    pair.first = static_cast<std::uint32_t>(number / kPairFactor);
    pair.second = static_cast<std::uint32_t>(number % kPairFactor);
    const std::vector<FacePixel>& first = features_of(features, pair.first);
    const std::vector<FacePixel>& second = features_of(features, pair.second);
    const std::vector<std::uint32_t> indices = matrix_at<std::uint32_t>(statement, 1, database);
    const auto columns = static_cast<std::size_t>(statement.integer(2));
    for (std::size_t at = 0; at < indices.size(); at += columns) {
      if (indices[at] >= first.size() || indices[at + 1] >= second.size()) {
        throw Error(fmt::format("{}: damaged; delete its directory and run poses again",
                                database.string()));
      }
      pair.in_first.push_back(first[indices[at]]);
      pair.in_second.push_back(second[indices[at + 1]]);
    }
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

}  // namespace raywalk::calibrate
