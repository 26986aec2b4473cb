// Masks of frames, from poses.csv to the room.
#include <gmock/gmock.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "build_lf/pack/derived_room.h"
#include "build_lf/pack/pack_room.h"
#include "build_lf/pack/station_data.h"
#include "build_lf/pack/test_pack.h"
#include "build_lf/quality/room_info.h"
#include "build_lf/quality/room_verify.h"
#include "core/files/atomic_output.h"
#include "core/files/test_support.h"

namespace raywalk::build_lf {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr int kWidth = TestCapture::kWidth;
constexpr int kHeight = TestCapture::kHeight;

// White except for the given rectangle.
cv::Mat mask_without(const cv::Rect& hidden, cv::Size size = {kWidth, kHeight}) {
  cv::Mat mask(size, CV_8UC1, cv::Scalar(255));
  mask(hidden).setTo(0);
  return mask;
}
const cv::Rect kNadir(0, 28, kWidth, 4);

class PackMasksTest : public PackTest {
 protected:
  // Writes the capture's list with a mask for every frame selected by `has_mask`, and one yaw for
  // all.
  template <typename HasMask>
  void write_list(const HasMask& has_mask, double yaw_deg = 0.0) const {
    capture_.write_rows("file,x,y,z,yaw,mask", [&](const TestCapture::Row& row) {
      return fmt::format("{},{},0,{},{},{}", row.file, row.x_m, row.z_m, yaw_deg,
                         has_mask(row.file) ? "mask.png" : "");
    });
  }
  void write_mask(const cv::Mat& mask) const {
    cv::imwrite((capture_.root() / "mask.png").string(), mask);
  }
  static bool every(const std::string&) { return true; }
  static bool of_front(const std::string& file) { return file.starts_with("front"); }
};

TEST(ValidRows, AreTheLongestRunOfEachColumn) {
  const cv::Mat columns = (cv::Mat_<uchar>(5, 6) << 255, 255, 255, 255, 255, 255,  //
                           0, 0, 0, 0, 0, 0,                                       //
                           255, 255, 0, 255, 255, 255,                             //
                           0, 0, 255, 255, 0, 0,                                   //
                           1, 0, 2, 255, 0, 0);
  const cv::Mat mask = columns.t();
  EXPECT_THAT(valid_rows_of(mask), ::testing::ElementsAre(0, 6, 0, 0, 3, 6, 2, 4, 2, 4));
}

TEST_F(PackMasksTest, RowsBelowAMaskAreInvalidAndTheirRaysAreKept) {
  write_list(of_front);
  write_mask(mask_without(kNadir));
  const Room room = pack();
  EXPECT_TRUE(room.masked());
  // x1 is the front line; only its frames have masks.
  EXPECT_TRUE(room.volume(1).masked());
  for (int theta = 0; theta < kWidth; ++theta) {
    EXPECT_EQ(room.volume(1).valid_rows(3, theta), (RowRun{0, 28}));
    EXPECT_EQ(room.volume(0).valid_rows(3, theta), (RowRun{0, kHeight}));
  }
  EXPECT_FALSE(room.volume(0).masked());
  const cv::Vec3b rgb = TestCapture::colour(3, 10, 30);
  EXPECT_EQ(room.volume(1).column(3, 10)[3 * 30], rgb[0]);
}

TEST_F(PackMasksTest, MasksAreRotatedWithTheirFrames) {
  write_list(every, 90.0);
  write_mask(mask_without({10, 20, 8, 12}));
  const Room room = pack();
  // A quarter of the width to the right, grown by one to two pixels, which cubic interpolation
  // reads.
  const int quarter = kWidth / 4;
  for (int u = 0; u < kWidth; ++u) {
    const int camera_u = (u - quarter + kWidth) % kWidth;
    const RowRun rows = room.volume(0).valid_rows(0, u);
    if (camera_u >= 10 && camera_u < 18) {
      EXPECT_GE(rows.end, 18) << u;
      EXPECT_LE(rows.end, 20) << u;
    } else if (camera_u < 8 || camera_u > 19) {
      // Half a turn away, rows at the nadir are read across the pole.
      EXPECT_GE(rows.end, kHeight - 2) << u;
    }
  }
}

TEST_F(PackMasksTest, TransparentPixelsAreMasked) {
  write_list([](const std::string&) { return false; });
  const fs::path file = capture_.root() / "front_2.png";
  const cv::Mat picture = cv::imread(file.string());
  cv::Mat transparent;
  cv::merge(std::vector{picture, mask_without(kNadir)}, transparent);
  cv::imwrite(file.string(), transparent);
  const fs::path opaque = capture_.root() / "back_2.png";
  cv::cvtColor(cv::imread(opaque.string()), transparent, cv::COLOR_BGR2BGRA);
  cv::imwrite(opaque.string(), transparent);
  const Room room = pack();
  EXPECT_EQ(room.volume(1).valid_rows(2, 5), (RowRun{0, 28}));
  EXPECT_EQ(room.volume(1).valid_rows(1, 5), (RowRun{0, kHeight}));
  EXPECT_FALSE(room.volume(0).masked()) << "an alpha channel that hides nothing";
  EXPECT_EQ(room.volume(1).column(2, 10)[3 * 20], TestCapture::colour(2, 10, 20)[0]);
}

TEST_F(PackMasksTest, OddMasksAreWarnedOfOnce) {
  write_list(of_front);
  const auto log_of = [&](const cv::Mat& mask) {
    write_mask(mask);
    const CapturedLog log;
    plan_pack(options_);
    return log.text();
  };
  EXPECT_EQ(log_of(mask_without(kNadir)), "");
  EXPECT_EQ(log_of(mask_without(kNadir) / 255), "") << "0 and 1";
  EXPECT_THAT(log_of(255 - mask_without(kNadir)),
              AllOf(HasSubstr("poses.csv:2: the mask"), HasSubstr("1 of 1"), HasSubstr("hides 9")));
  // From the equator to 11 degrees below it; all below that goes too.
  EXPECT_THAT(log_of(mask_without({8, 16, 12, 2})),
              AllOf(HasSubstr("hides 1.8 %"), HasSubstr("9.4 % in the room")));
}

TEST_F(PackMasksTest, VerifyDetectsAChangedMask) {
  write_list(every);
  write_mask(mask_without(kNadir));
  pack();
  EXPECT_EQ(verify_room(Room::open(capture_.room())).panoramas, kStations);
  const fs::path file = line_volume_path(capture_.room(), "x0");
  // The runs of a whole station, {0, 28} in every column.
  std::string runs;
  for (int u = 0; u < kWidth; ++u) runs += std::string("\0\0\0\0\x1c\0\0\0", 8);
  const std::size_t at = read_file(file).find(runs);
  ASSERT_NE(at, std::string::npos);
  std::string changed = read_file(file);
  changed[at + 4] = '\x20';
  write_file_atomically(file, changed);
  EXPECT_THAT(error_of([&] { verify_room(Room::open(capture_.room())); }),
              AllOf(HasSubstr("line x0 station 0"), HasSubstr("rays")));
}

TEST_F(PackMasksTest, InfoShowsTheMaskedShareOfTheSolidAngle) {
  write_list(of_front);
  write_mask(mask_without({0, 16, kWidth, 16}));
  const RoomInfo info = info_of(pack());
  EXPECT_NEAR(info.lines[1].masked_share, 0.5, 1e-12);
  EXPECT_EQ(info.lines[0].masked_share, 0.0);
  EXPECT_NEAR(info.masked_share, 0.125, 1e-12);
  EXPECT_THAT(text_of(info, "room.lf"), AllOf(HasSubstr("12.50 % masked"), HasSubstr("50.00 %")));
  EXPECT_THAT(json_of(info), HasSubstr("\"masked_share\": 0.125"));
}

TEST_F(PackMasksTest, ThinnedRoomsKeepTheirMasks) {
  write_list(every);
  write_mask(mask_without(kNadir));
  const Room room = pack();
  const fs::path thin = capture_.root() / "thin.lf";
  write_thinned_room(room, {{0, 3, 6}, {0, 3, 6}, {0, 3, 6}, {0, 3, 6}}, kWidth, thin);
  const Room thinned = Room::open(thin);
  EXPECT_EQ(thinned.volume(2).valid_rows(1, 7), (RowRun{0, 28}));
  EXPECT_EQ(verify_room(thinned).panoramas, 12);
}

TEST_F(PackMasksTest, TheMaskIsAnInput) {
  write_list(every);
  write_mask(mask_without(kNadir));
  const std::vector<LineInputs> first = plan_pack(options_).inputs;
  write_mask(mask_without({3, 3, 20, 20}));
  EXPECT_NE(plan_pack(options_).inputs, first);
}

TEST_F(PackMasksTest, InvalidMasksAreNamedWithTheirListLine) {
  write_list([](const std::string& file) { return file == "front_4.png"; });
  EXPECT_THAT(clean_error(), AllOf(HasSubstr("poses.csv:6"), HasSubstr("mask.png")));
  write_mask(mask_without({0, 0, 4, 4}, {32, 16}));
  EXPECT_THAT(clean_error(),
              AllOf(HasSubstr("poses.csv:6"), HasSubstr("32x16"), HasSubstr("64x32")));
  write_mask(cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(255)));
  EXPECT_THAT(clean_error(), AllOf(HasSubstr("poses.csv:6"), HasSubstr("8-bit grey")));
  std::ofstream(capture_.root() / "mask.png") << "text";
  EXPECT_THAT(clean_error(), AllOf(HasSubstr("poses.csv:6"), HasSubstr("mask.png")));
  // Cut short, which shows when its line is packed.
  cv::Mat noise(kHeight, kWidth, CV_8UC1);
  cv::randu(noise, 0, 256);
  write_mask(noise);
  fs::resize_file(capture_.root() / "mask.png", fs::file_size(capture_.root() / "mask.png") - 20);
  EXPECT_THAT(error(), AllOf(HasSubstr("poses.csv:6"), HasSubstr("mask.png")));
}

}  // namespace
}  // namespace raywalk::build_lf
