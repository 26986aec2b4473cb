#include "core/panorama/picture_look.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <vector>

#include "core/files/image_file.h"
#include "core/geometry/sphere.h"

namespace raywalk {
namespace {

constexpr PanoramaSize kSize{512, 256};

// A light, busy scene: grey levels about 128 by direction.
class Scene {
 public:
  explicit Scene(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(-1.0, 1.0);
    for (Wave& wave : waves_) {
      wave.along = 6.0 * Eigen::Vector3d(number(random), number(random), number(random));
      wave.phase = 3.0 * number(random);
    }
  }
  double at(const Eigen::Vector3d& direction) const {
    double level = 128.0;
    for (const Wave& wave : waves_)
      level += 25.0 * std::sin(wave.along.dot(direction) + wave.phase);
    return level;
  }

 private:
  struct Wave {
    Eigen::Vector3d along;
    double phase = 0.0;
  };
  std::array<Wave, 6> waves_{};
};

cv::Mat drawn(const std::function<double(int, int)>& level) {
  cv::Mat picture(kSize.height, kSize.width, CV_8UC1);
  for (int v = 0; v < kSize.height; ++v) {
    for (int u = 0; u < kSize.width; ++u) {
      picture.at<uchar>(v, u) = cv::saturate_cast<uchar>(level(u, v));
    }
  }
  return picture;
}

cv::Mat panorama_of(const Scene& scene) {
  return drawn([&](int u, int v) {
    return scene.at(direction_from_angles(angles_from_pixel({double(u), double(v)}, kSize)));
  });
}

// Two circles of `radius` half heights, each of 190 degrees.
cv::Mat dual_fisheye_of(const Scene& scene, double radius) {
  return drawn([&](int u, int v) {
    const bool back = u >= kSize.height;
    const double half = 0.5 * kSize.height;
    const double x = (u % kSize.height + 0.5 - half) / half, y = (v + 0.5 - half) / half;
    const double from_centre = std::hypot(x, y);
    if (from_centre > radius) return 0.0;
    const double angle = from_centre / radius * 95.0 * M_PI / 180.0;
    const double side = std::sin(angle) / std::max(from_centre, 1e-9);
    const Eigen::Vector3d direction(side * x, side * y, std::cos(angle));
    return scene.at(back ? Eigen::Vector3d(-direction.x(), direction.y(), -direction.z())
                         : direction);
  });
}

cv::Mat with_noise(const cv::Mat& picture, double sigma, unsigned seed) {
  cv::RNG random(seed);
  cv::Mat noise(picture.size(), CV_16SC1), sum;
  random.fill(noise, cv::RNG::NORMAL, 0.0, sigma);
  cv::add(picture, noise, sum, cv::noArray(), CV_8U);
  return sum;
}

TEST(PictureLookProperty, GeneratedPicturesAreRecognisedAlsoWithNoise) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    const Scene scene(seed);
    for (const double sigma : {0.0, 3.0}) {
      EXPECT_EQ(look_at_picture(with_noise(panorama_of(scene), sigma, seed)),
                PictureKind::kPanorama)
          << "seed " << seed << ", noise " << sigma;
      const double radius = 0.93 + 0.003 * seed;
      EXPECT_EQ(look_at_picture(with_noise(dual_fisheye_of(scene, radius), sigma, seed)),
                PictureKind::kDualFisheye)
          << "seed " << seed << ", noise " << sigma;
    }
  }
}

TEST(PictureLookProperty, DarkOrNoisyPicturesAreNeverTakenForTheOtherKind) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const Scene scene(seed);
    const cv::Mat panorama = panorama_of(scene), fisheyes = dual_fisheye_of(scene, 0.97);
    for (const double light : {0.5, 0.1, 0.02}) {
      for (const double sigma : {1.0, 10.0, 60.0}) {
        const auto seen = [&](const cv::Mat& picture) {
          return look_at_picture(with_noise(picture * light, sigma, seed));
        };
        EXPECT_NE(seen(panorama), PictureKind::kDualFisheye) << seed;
        EXPECT_NE(seen(fisheyes), PictureKind::kPanorama) << seed;
      }
    }
  }
}

TEST(PictureLook, IsUnclearWhereNothingTells) {
  const Scene scene(1);
  const cv::Mat panorama = panorama_of(scene);
  cv::Mat cut = panorama.clone(), shifted = panorama.clone();
  panorama.rowRange(64, 192).copyTo(cut.rowRange(0, 128));
  for (int v = 0; v < shifted.rows; ++v) {  // left and right edges apart
    for (int u = 0; u < 32; ++u) shifted.at<uchar>(v, u) = static_cast<uchar>((7 * v) % 251);
  }
  struct Case {
    std::string what;
    cv::Mat picture;
  };
  const std::vector<Case> cases = {
      {"nothing", {}},
      {"black", drawn([](int, int) { return 0.0; })},
      {"white", drawn([](int, int) { return 255.0; })},
      {"a gradient from sky to ground", drawn([](int, int v) { return double(v); })},
      {"noise", with_noise(drawn([](int, int) { return 128.0; }), 60.0, 1)},
      {"another aspect ratio", panorama.colRange(0, 400)},
      {"a band of a panorama", cut},
      {"edges apart", shifted},
      {"a single circle", dual_fisheye_of(scene, 0.97).colRange(0, 256)},
      {"two lamps in the dark", drawn([](int u, int v) {
         return 255.0 * std::exp(-0.002 * (std::pow(u % 256 - 128, 2) + std::pow(v - 128, 2)));
       })},
      {"a few pixels", cv::Mat(32, 64, CV_8UC1, cv::Scalar(9))}};
  for (const Case& each : cases) {
    EXPECT_EQ(look_at_picture(each.picture), PictureKind::kUnclear) << each.what;
  }
}

TEST(PictureLook, PanoramasOfTheEmbeddedRoomAreNotTakenForFisheyes) {
  int recognised = 0, all = 0;
  const std::filesystem::path folder = std::filesystem::path(RAYWALK_TEST_ROOM) / "capture";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const PictureKind kind = look_at_picture(read_picture(entry.path()));
    EXPECT_NE(kind, PictureKind::kDualFisheye) << entry.path();
    recognised += kind == PictureKind::kPanorama ? 1 : 0;
    ++all;
  }
  EXPECT_GE(recognised, all * 8 / 10);
}

TEST(PictureLook, FilesAreDecodedAndOthersAreUnclear) {
  std::vector<uchar> file;
  cv::imencode(".jpg", dual_fisheye_of(Scene(3), 0.97), file);
  EXPECT_EQ(look_at_picture(std::as_bytes(std::span(file))), PictureKind::kDualFisheye);
  const std::string text = "shot 3";
  EXPECT_EQ(look_at_picture(std::as_bytes(std::span(text))), PictureKind::kUnclear);
  EXPECT_EQ(look_at_picture(std::span<const std::byte>{}), PictureKind::kUnclear);
}

}  // namespace
}  // namespace raywalk
