#include "core/view/gain_rows.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <opencv2/core.hpp>

#include "core/files/atomic_output.h"
#include "core/room/hdf5_file.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

namespace fs = std::filesystem;

// Exposures that darken parts of a station's panorama: [theta][phi], as GainField::local.
cv::Mat exposure_of(int line, int station) {
  cv::RNG random(static_cast<std::uint64_t>(100 * line + station + 1));
  cv::Mat exposure(16, 8, CV_32FC3);
  const float whole = random.uniform(0.75F, 1.0F);
  for (int theta = 0; theta < exposure.rows; ++theta) {
    const float lens = theta < 8 ? 0.9F : 1.0F;
    exposure.row(theta) = cv::Scalar(whole * lens, whole * lens * 0.95F, whole * lens);
  }
  return exposure;
}

// Multiplies the stored rays of a line by its stations' exposures.
void expose_line(const fs::path& file, int line) {
  const Hdf5Handle opened(H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose);
  const Hdf5Handle rays(H5Dopen2(opened.get(), "rays", H5P_DEFAULT), H5Dclose);
  const Hdf5Handle space(H5Dget_space(rays.get()), H5Sclose);
  hsize_t shape[4];
  H5Sget_simple_extent_dims(space.get(), shape, nullptr);
  const int stations = static_cast<int>(shape[0]);
  const int stored_columns = static_cast<int>(shape[1]);
  const int height = static_cast<int>(shape[2]);
  const int width = 2 * height;
  const PolarPart polar_part({width, height});
  cv::Mat all(stations * stored_columns, height, CV_8UC3);
  H5Dread(rays.get(), H5T_NATIVE_UINT8, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data);
  for (int station = 0; station < stations; ++station) {
    cv::Mat panorama = all.rowRange(station * stored_columns, station * stored_columns + width);
    cv::Mat exposed = panorama.clone();
    apply_gains({.local = exposure_of(line, station)}, &exposed);
    exposed.copyTo(panorama);
    const std::size_t bytes = 3 * panorama.total();
    polar_part.fill(
        {panorama.data, bytes},
        {panorama.data + bytes, static_cast<std::size_t>(3 * height * (stored_columns - width))});
  }
  H5Dwrite(rays.get(), H5T_NATIVE_UINT8, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data);
}

// A room as captured, and the same with other exposures at every station and gains that undo them.
class GainRowsTest : public ::testing::Test {
 protected:
  GainRowsTest() {
    for (const char* name : {"clean.lf", "exposed.lf"})
      write_synthetic_room(spec_, directory_ / name);
    const fs::path exposed = directory_ / "exposed.lf";
    RoomManifest manifest = read_manifest(exposed);
    GainFields gains = unit_gain_fields(manifest.grid);
    for (int line = 0; line < static_cast<int>(gains.size()); ++line) {
      auto& fields = gains[static_cast<size_t>(line)];
      expose_line(line_volume_path(exposed, manifest.grid.lines[static_cast<size_t>(line)].id),
                  line);
      for (int station = 0; station < static_cast<int>(fields.size()); ++station) {
        cv::divide(1.0, exposure_of(line, station), fields[static_cast<size_t>(station)].local);
      }
    }
    write_gain_fields(gains_path(exposed), manifest.grid, gains);
    clean_ = Room::open(directory_ / "clean.lf");
    without_gains_ = Room::open_without_gains(exposed);
    manifest.gains = {record_of_gains(gains_path(exposed))};
    write_file_atomically(manifest_path(exposed), manifest_to_json(manifest));
    exposed_ = Room::open(exposed);
  }

  // PSNR of the exposed room's view to that of the room as captured.
  double psnr(const ViewOptions& options, PlanPoint at) const {
    return psnr_db(image(exposed_, options, at), image(clean_, options, at));
  }

  static cv::Mat image(const Room& room, const ViewOptions& options, PlanPoint at) {
    return Renderer(room, options).render(at).image;
  }

  SyntheticRoomSpec spec_ = [] {
    SyntheticRoomSpec spec = box_room(128);
    spec.spacing_m = 0.25;
    return spec;
  }();
  TestDirectory directory_;
  Room clean_, exposed_, without_gains_;
  static constexpr PlanPoint kAt{0.13, -0.21};
};

TEST_F(GainRowsTest, ViewsAreThoseOfEqualExposures) {
  for (const Generation generation :
       {Generation::kInitial, Generation::kHlfVd, Generation::kTwoSided}) {
    for (const Interpolation interpolation :
         {Interpolation::kNearest, Interpolation::kLinear, Interpolation::kCubic}) {
      const ViewOptions options{.generation = generation, .interpolation = interpolation};
      EXPECT_GT(psnr(options, kAt), 38.0) << generation_name(generation);
      ViewOptions off = options;
      off.gains = false;
      EXPECT_LT(psnr(off, kAt), 25.0) << generation_name(generation);
    }
  }
}

TEST_F(GainRowsTest, SoAreThoseWithOtherOptions) {
  const ViewOptions two_sided{.generation = Generation::kTwoSided};
  for (const double skip_px : {0.5, 4.0}) {
    for (const Generation generation : {Generation::kHlfVd, Generation::kTwoSided}) {
      EXPECT_GT(psnr({.generation = generation, .skip_px = skip_px}, kAt), 38.0) << skip_px;
    }
  }
  ViewOptions options = two_sided;
  options.stations_mixed = 1;
  EXPECT_GT(psnr(options, kAt), 38.0);
  options = two_sided;
  options.second_side = SecondSide::kWhereHidden;
  EXPECT_GT(psnr(options, kAt), 38.0);
  options = two_sided;
  options.arithmetic = Arithmetic::kDouble;
  EXPECT_GT(psnr(options, kAt), 38.0);
  options = two_sided;
  options.layers = 8;
  EXPECT_GT(psnr(options, kAt), 38.0);
  options = two_sided;
  options.station_stride = 2;
  EXPECT_GT(psnr(options, kAt), 38.0);
  for (const int width : {64, 256}) {
    EXPECT_GT(psnr({.generation = Generation::kInitial, .width = width}, kAt), 38.0) << width;
    EXPECT_GT(psnr({.generation = Generation::kTwoSided, .width = width}, kAt), 38.0) << width;
  }
}

TEST_F(GainRowsTest, SoAreFlatPictures) {
  const Viewport viewport{.width = 96, .height = 64};
  for (const Generation generation : {Generation::kInitial, Generation::kTwoSided}) {
    const ViewOptions options{.generation = generation};
    EXPECT_GT(psnr_db(Renderer(exposed_, options).render(kAt, viewport).image,
                      Renderer(clean_, options).render(kAt, viewport).image),
              38.0);
  }
}

TEST_F(GainRowsTest, SwitchedOffTheViewIsAsCaptured) {
  for (const Generation generation :
       {Generation::kInitial, Generation::kHlfVd, Generation::kTwoSided}) {
    const ViewOptions off{.generation = generation, .gains = false};
    EXPECT_EQ(largest_difference(image(exposed_, off, kAt),
                                 image(without_gains_, {.generation = generation}, kAt)),
              0.0);
  }
}

// Bright levels end at 255 instead of starting again at 0.
TEST_F(GainRowsTest, LevelsEndAtWhite) {
  GainFields gains = unit_gain_fields(clean_.grid());
  for (auto& line : gains) {
    for (GainField& field : line) field.whole = {8.0F, 8.0F, 8.0F};
  }
  const fs::path room = directory_ / "clean.lf";
  write_gain_fields(gains_path(room), clean_.grid(), gains);
  RoomManifest manifest = read_manifest(room);
  manifest.gains = {record_of_gains(gains_path(room))};
  write_file_atomically(manifest_path(room), manifest_to_json(manifest));
  for (const Generation generation : {Generation::kInitial, Generation::kTwoSided}) {
    const cv::Mat view = image(Room::open(room), {.generation = generation}, kAt);
    double darkest = 0.0;
    cv::minMaxLoc(view.reshape(1), &darkest);
    EXPECT_EQ(darkest, 255.0);
  }
}

TEST_F(GainRowsTest, GainsAreInterpolatedBetweenPatchesAndAcrossTheSeam) {
  const RoomGains gains(exposed_);
  const cv::Mat field = exposed_.gains()[1][2].local;
  const auto gain_at = [&](float u, float v) {
    std::array<float, 3> rgb{};
    gains.add(1, 2, 1.0F, u, v, rgb.data());
    return rgb[1];
  };
  EXPECT_NEAR(gain_at(2.5F / 16.0F, 0.3F), field.at<cv::Vec3f>(2, 2)[1], 1e-5);
  EXPECT_NEAR(gain_at(0.5F, 0.3F),
              0.5 * (field.at<cv::Vec3f>(7, 2)[1] + field.at<cv::Vec3f>(8, 2)[1]), 1e-5);
  const double at_seam = 0.5 * (field.at<cv::Vec3f>(15, 2)[1] + field.at<cv::Vec3f>(0, 2)[1]);
  EXPECT_NEAR(gain_at(0.0F, 0.3F), at_seam, 1e-5);
  EXPECT_NEAR(gain_at(1.0F - 1e-6F, 0.3F), at_seam, 1e-4);
}

}  // namespace
}  // namespace raywalk
