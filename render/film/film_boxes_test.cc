#include "render/film/film_boxes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "core/base/error.h"
#include "core/base/test_error.h"
#include "render/film/film_layout.h"
#include "render/film/spherical_boxes.h"

namespace raywalk::render {
namespace {

using ::testing::HasSubstr;

// A track of pictures of 64 x 32 with chunks at the given places.
FilmBox movie_with(const std::string& offsets_type, const std::vector<std::uint64_t>& offsets) {
  std::string entry(78, '\0');
  entry[25] = 64;
  entry[27] = 32;
  std::string table(4, '\0');
  put_u32(static_cast<std::uint32_t>(offsets.size()), &table);
  for (const std::uint64_t offset : offsets) {
    if (offsets_type == "co64")
      put_u64(offset, &table);
    else
      put_u32(static_cast<std::uint32_t>(offset), &table);
  }
  const FilmBox descriptions{.type = "stsd",
                             .payload = std::string("\0\0\0\0\0\0\0\1", 8),
                             .children = {{.type = "avc1", .payload = entry}}};
  const FilmBox samples{.type = "stbl",
                        .children = {descriptions, {.type = offsets_type, .payload = table}}};
  const FilmBox media{.type = "minf", .children = {{.type = "vmhd"}, samples}};
  const FilmBox track{.type = "trak", .children = {{.type = "mdia", .children = {media}}}};
  return {.type = "moov", .children = {{.type = "mvhd", .payload = "1234"}, track}};
}

const FilmBox& table_of(const FilmBox& movie) {
  return movie.child("trak")->child("mdia")->child("minf")->child("stbl")->children[1];
}

TEST(FilmBoxes, AreReadAsTheyWereWritten) {
  FilmBox movie = movie_with("stco", {100, 200});
  movie.child("trak")->child("mdia")->child("minf")->child("stbl")->children[0].children[0].tail =
      std::string(4, '\0');  // as QuickTime ends lists
  add_spherical_metadata(StereoMode::kTopBottom, "a.mp4", &movie);
  const std::string bytes = bytes_of(movie);
  const FilmBox again = parse_box(bytes, "a.mp4");
  EXPECT_EQ(bytes_of(again), bytes);
  const SphericalMetadata metadata = spherical_metadata_of(*again.child("trak"));
  EXPECT_TRUE(metadata.is_equirectangular);
  EXPECT_EQ(metadata.stereo, StereoMode::kTopBottom);
  EXPECT_THAT(again.child("trak")->child("uuid")->payload,
              HasSubstr("<GSpherical:StereoMode>top-bottom<"));
  FilmBox empty{.type = "moov"};
  EXPECT_THAT(error_of([&] { add_spherical_metadata(StereoMode::kMono, "a.mp4", &empty); }),
              HasSubstr("a.mp4: the film has no track of pictures"));
}

// Whatever bytes there are, they are read or refused with the film's name.
TEST(FilmBoxes, DamagedBytesDoNoHarm) {
  const std::string whole = bytes_of(movie_with("stco", {100, 200}));
  const auto read = [](const std::string& bytes) {
    try {
      const FilmBox box = parse_box(bytes, "a.mp4");
      moved_movie({{"moov", 0, bytes.size()}, {"mdat", bytes.size(), 1000}}, box, "a.mp4");
      for (const FilmBox& track : box.children) spherical_metadata_of(track);
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), HasSubstr("a.mp4"));
    }
  };
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_THAT(error_of([&] { parse_box(whole.substr(0, size), "a.mp4"); }), HasSubstr("damaged"));
    read(whole.substr(0, size));
  }
  std::mt19937 random(1);
  for (int i = 0; i < 20000; ++i) {
    std::string damaged = whole;
    for (int k = 0; k < 3; ++k) {
      const char values[] = {'\0', '\1', '\x7f', '\xff', static_cast<char>(random())};
      damaged[random() % damaged.size()] = values[random() % 5];
    }
    read(damaged);
  }
  FilmBox nested{.type = "moov"};
  for (int depth = 0; depth < 200; ++depth) nested = {.type = "trak", .children = {nested}};
  EXPECT_THAT(error_of([&] { parse_box(bytes_of(nested), "a.mp4"); }), HasSubstr("damaged"));
}

TEST(FilmLayout, ChunksMoveWithTheFrames) {
  const FilmBox movie = movie_with("stco", {40, 900});
  const std::vector<TopBox> boxes = {{"ftyp", 0, 32}, {"mdat", 32, 1000}, {"moov", 1000, 1300}};
  const FilmBox moved = parse_box(moved_movie(boxes, movie, "a.mp4"), "a.mp4");
  const std::size_t shift = bytes_of(movie).size();
  EXPECT_EQ(get_u32(table_of(moved).payload, 8), 40 + shift);
  EXPECT_EQ(get_u32(table_of(moved).payload, 12), 900 + shift);
  const FilmLayout layout(boxes, shift);
  EXPECT_EQ(layout.end(), 1000 + shift);
  EXPECT_EQ(layout.before().size(), 1U);
  EXPECT_EQ(layout.behind().front().type, "mdat");
  EXPECT_THAT(error_of([&] { moved_movie(boxes, movie_with("stco", {1100}), "a.mp4"); }),
              HasSubstr("a.mp4: the film is damaged"));
}

TEST(FilmLayout, OffsetsGetWiderWhereTheFilmGrowsBeyond4GiB) {
  const std::uint64_t end = std::numeric_limits<std::uint32_t>::max() - 10ULL;
  const std::vector<TopBox> boxes = {{"ftyp", 0, 32}, {"mdat", 32, end}, {"moov", end, end + 300}};
  const FilmBox movie = movie_with("stco", {40, end - 1});
  const std::string bytes = moved_movie(boxes, movie, "a.mp4");
  const FilmBox moved = parse_box(bytes, "a.mp4");
  EXPECT_EQ(table_of(moved).type, "co64");
  EXPECT_EQ(bytes.size(), bytes_of(movie).size() + 8);
  EXPECT_EQ(get_u64(table_of(moved).payload, 16), end - 1 + bytes.size());
}

}  // namespace
}  // namespace raywalk::render
