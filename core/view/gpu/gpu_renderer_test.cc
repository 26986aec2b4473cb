// Views on a graphics card, or on what stands in for one, beside those of the processor.
#include "core/view/gpu/gpu_renderer.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <deque>
#include <future>
#include <string>
#include <vector>

#include "core/files/test_support.h"
#include "core/view/gpu/gpu_device.h"
#include "core/view/test_room.h"

namespace raywalk {
namespace {

constexpr double kLeastPsnr_db = 50.0;
constexpr int kFewPanoramas = 9;  // enough for a column, and one to fill from
// None on a face of the pillar, of which rounding would decide what is seen.
constexpr PlanPoint kViewpoints[] = {{0.0, 0.0},    {0.06, 0.2},   {-0.3, 0.25}, {0.45, -0.2},
                                     {-0.48, 0.1},  {0.2, -0.45},  {0.33, 0.31}, {-0.2, -0.4},
                                     {0.05, -0.07}, {-0.41, 0.44}, {0.5, 0.1},   {0.47, 0.47}};

// Views are rendered on `device` while it lives, and not by the processor in its place.
class OnDevice {
 public:
  explicit OnDevice(Device device, double gpu_mb = 512.0) { choose_device(device, gpu_mb); }
  ~OnDevice() {
    choose_device(Device::kCpu);
    EXPECT_EQ(log_.text(), "");
  }
  OnDevice(const OnDevice&) = delete;
  OnDevice& operator=(const OnDevice&) = delete;

 private:
  CapturedLog log_;
};

SyntheticRoomSpec hiding(SyntheticRoomSpec spec, bool moved) {
  spec.companion.emplace().hides = [](const std::string&, int station,
                                      const Eigen::Vector3d& direction) {
    return direction.y() < -0.8 || (station % 3 == 1 && direction.x() > 0.85);
  };
  spec.companion->masked = !moved;
  spec.companion->left_out = moved;
  return spec;
}

SyntheticRoomSpec sparse_maps() {
  SyntheticRoomSpec spec = pillar_spec();
  spec.distance_every = 4;
  spec.distance_width = 64;
  spec.stored_confidence = [](int u, int) {
    return static_cast<std::uint8_t>(u % 3 == 0 ? 255 : 0);
  };
  return spec;
}

// Most distances are unreliable, but none in a part of the columns.
SyntheticRoomSpec half_known() {
  SyntheticRoomSpec spec = sparse_maps();
  spec.stored_confidence = [](int u, int) { return static_cast<std::uint8_t>(u < 30 ? 255 : 0); };
  return spec;
}

SyntheticRoomSpec compressed_room() {
  SyntheticRoomSpec spec = box_room(96);
  spec.form = {.kind = RayForm::Kind::kLossless};
  return spec;
}

struct RoomCase {
  const char* name;
  SyntheticRoomSpec (*spec)();
};
const RoomCase kRooms[] = {
    {"box", [] { return box_room(128); }},
    {"pillar", [] { return pillar_spec(192); }},
    {"masked", [] { return hiding(pillar_spec(128), false); }},
    {"moved", [] { return hiding(pillar_spec(128), true); }},
    {"sparse", sparse_maps},
    {"half_known", half_known},
    {"compressed", compressed_room},
};

class GpuRoom : public testing::TestWithParam<RoomCase> {
 protected:
  const TestRoom room_{GetParam().spec()};
};

void expect_agreement(const RenderedView& gpu, const RenderedView& cpu, const std::string& what) {
  ASSERT_EQ(gpu.image.size(), cpu.image.size());
  EXPECT_GE(psnr_db(gpu.image, cpu.image), kLeastPsnr_db) << what;
  constexpr double kShare = 0.002;  // of pixels that rounding may decide
  EXPECT_NEAR(gpu.report.filled_share, cpu.report.filled_share, kShare) << what;
  EXPECT_NEAR(gpu.report.unseen_share, cpu.report.unseen_share, kShare) << what;
  EXPECT_NEAR(gpu.report.empty_share, cpu.report.empty_share, kShare) << what;
}

TEST_P(GpuRoom, ViewsAreThoseOfTheProcessor) {
  std::vector<ViewOptions> all;
  for (const ViewMethod method : kViewMethods) {
    all.push_back({.method = method});
    all.push_back({.method = method, .k_deg = 60.0, .width = 64});
    all.push_back({.method = method,
                   .k_deg = 76.0,
                   .interpolation = Interpolation::kCubic,
                   .stations_mixed = 8});
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    const ViewOptions& options = all[i];
    Renderer cpu(room_.room(), options);
    const OnDevice device(Device::kGpu);
    ASSERT_TRUE(on_graphics_card());
    Renderer gpu(room_.room(), options);
    // Half of the places: each is seen by every method and with each of the three settings.
    for (std::size_t place = i % 2; place < std::size(kViewpoints); place += 2) {
      const PlanPoint at = kViewpoints[place];
      expect_agreement(gpu.render(at), cpu.render(at),
                       fmt::format("{} at {}, {}", text_of(options), at.x_m, at.z_m));
    }
  }
}

TEST_P(GpuRoom, TwoEyesFlatPicturesAndAnotherHeightToo) {
  const ViewOptions options{.method = ViewMethod::kTwoSided};
  Renderer cpu(room_.room(), options);
  const OnDevice device(Device::kGpu);
  Renderer gpu(room_.room(), options);
  const PlanPoint at{0.21, -0.13};
  const Viewport tilted{
      .attitude = {.yaw_rad = 2.8, .pitch_rad = -0.5, .roll_rad = 0.2}, .width = 60, .height = 80};
  expect_agreement(gpu.render_stereo(at, 0.063), cpu.render_stereo(at, 0.063), "stereo");
  expect_agreement(gpu.render(at, tilted), cpu.render(at, tilted), "flat");
  expect_agreement(gpu.render(Viewpoint(at, 0.11)), cpu.render(Viewpoint(at, 0.11)), "height");
}

// Behind a pillar, and where stations are masked, more of them are needed than those of a column's
// lines.
TEST_P(GpuRoom, LargerThanTheCardsMemoryIsRenderedPartByPart) {
  const ViewOptions options{.method = ViewMethod::kTwoSided};
  const PanoramaSize size = room_.room().panorama();
  const auto views = [&](int panoramas) {
    const OnDevice device(Device::kGpu, 1e-6 * (4.0 * size.width * size.height * panoramas + 1.0));
    Renderer renderer(room_.room(), options);
    cv::Mat all = renderer.render({0.05, 0.2}).image;
    for (const PlanPoint at : kViewpoints) all.push_back(renderer.render(at).image);
    return all;
  };
  EXPECT_EQ(largest_difference(views(1000), views(kFewPanoramas)), 0.0);
}

INSTANTIATE_TEST_SUITE_P(Rooms, GpuRoom, testing::ValuesIn(kRooms),
                         [](const auto& room) { return room.param.name; });

TEST(GpuGains, StationsAreShownWithThem) {
  // The processor interpolates gains between every eighth row; these change slowly.
  const RoomWithGains room(pillar_spec(), [](int line, int station) {
    GainField field;
    field.whole = {0.8f + 0.02f * static_cast<float>(station), 1.0f,
                   1.1f - 0.05f * static_cast<float>(line)};
    field.local = cv::Mat(2, 1, CV_32FC3, cv::Scalar(0.95, 1.0, 1.05));
    return field;
  });
  for (const int stations : {1, 16}) {
    const ViewOptions options{.method = ViewMethod::kTwoSided, .stations_mixed = stations};
    Renderer cpu(room.room(), options);
    const OnDevice device(Device::kGpu);
    Renderer gpu(room.room(), options);
    for (const PlanPoint at : kViewpoints) {
      expect_agreement(gpu.render(at), cpu.render(at), fmt::format("{} stations", stations));
    }
  }
}

TEST(GpuMemory, WithoutRoomForAColumnTheProcessorRenders) {
  const TestRoom room(box_room(128));
  const ViewOptions options{.method = ViewMethod::kTwoSided, .stations_mixed = 8};
  const cv::Mat cpu = room.image(options, {0.1, 0.2});
  for (const double gpu_mb : {0.0, 0.034}) {
    const CapturedLog log;
    choose_device(Device::kGpu, gpu_mb);
    EXPECT_EQ(largest_difference(room.image(options, {0.1, 0.2}), cpu), 0.0) << gpu_mb;
    choose_device(Device::kCpu);
    EXPECT_THAT(log.text(), testing::HasSubstr("the processor renders views")) << gpu_mb;
  }
}

TEST(GpuDevice, AutoDoesNotTakeWhatStandsInForACard) {
  const OnDevice device(Device::kAuto);
  if (on_graphics_card()) {
    EXPECT_EQ(device_name().find("llvmpipe"), std::string::npos);
  } else {
    EXPECT_EQ(device_name(), "the processor");
  }
}

// With little memory each view replaces panoramas that others wait to read.
TEST(GpuDevice, ViewsInThreadsAreThoseOfOneThread) {
  const TestRoom room(hiding(pillar_spec(128), false));
  const PanoramaSize size = room.room().panorama();
  for (const int panoramas : {1000, kFewPanoramas}) {
    const OnDevice device(Device::kGpu, 1e-6 * (4.0 * size.width * size.height * panoramas + 1.0));
    std::deque<Renderer> renderers;
    for (const ViewMethod method : kViewMethods) {
      renderers.emplace_back(room.room(), ViewOptions{.method = method});
    }
    const auto views = [](Renderer* renderer) {
      cv::Mat all = renderer->render(kViewpoints[5]).image;
      for (const PlanPoint at : {kViewpoints[1], kViewpoints[7], kViewpoints[9]}) {
        all.push_back(renderer->render(at).image);
      }
      return all;
    };
    std::vector<cv::Mat> expected;
    for (Renderer& renderer : renderers) expected.push_back(views(&renderer));
    std::vector<std::future<cv::Mat>> found;
    for (Renderer& renderer : renderers) {
      found.push_back(std::async(std::launch::async, views, &renderer));
    }
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(largest_difference(found[i].get(), expected[i]), 0.0) << i << " of " << panoramas;
    }
  }
}

}  // namespace
}  // namespace raywalk
