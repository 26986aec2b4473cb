// End-to-end test of raywalk-render path.
#include <fstream>
#include <string>
#include <vector>

#include "core/files/image_file.h"
#include "tests/end_to_end/render_command.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

// A path with enough views to be interrupted midway.
class RenderPathTest : public RenderTest {
 protected:
  static constexpr int kViews = 60;
  RenderPathTest() {
    make_room();
    std::ofstream list(file("path.csv"));
    list << "name,x,z\n";
    for (int i = 0; i < kViews; ++i) list << "view" << i << "," << 0.4 - 0.01 * i << ",0.1\n";
  }
  std::vector<std::string> arguments() const {
    return {RAYWALK_RENDER, "path",    room(), file("path.csv"), "--method",
            "initial",      "--width", "1024", "--out",          file("views")};
  }
  std::string command() const { return joined(arguments()); }
  // The number of complete pictures; any other file except the record is a failure.
  size_t pictures() const {
    size_t count = 0;
    for (const auto& entry : fs::directory_iterator(file("views"))) {
      if (entry.path().filename() == "views.json") continue;
      EXPECT_EQ(read_panorama(entry.path()).cols, 1024);
      ++count;
    }
    return count;
  }
};

TEST_F(RenderPathTest, CtrlCStopsCleanlyAndTheSameCommandResumes) {
  interrupt_once_there(arguments(), file("views/view1.png"));
  const size_t before = pictures();
  EXPECT_GE(before, 2U);
  EXPECT_LT(before, static_cast<size_t>(kViews));

  const CommandResult resumed = run_command(command());
  EXPECT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_THAT(resumed.output, HasSubstr(std::to_string(kViews - before) + " of them rendered now"));
  EXPECT_EQ(pictures(), static_cast<size_t>(kViews));
}

TEST_F(RenderPathTest, OtherSettingsAreRefused) {
  std::ofstream(file("path.csv")) << "name,x,z\na,0,0\n";
  ASSERT_EQ(run_command(command()).exit_code, 0);
  expect_error(run_command(command() + "--overlap-deg 9"), 1, "overlap_deg", 3);
}

TEST_F(RenderPathTest, AVideoIsWholeOrNothing) {
  const std::string video = file("walk.mp4");
  const std::string usual = "path " + room() + " " + file("path.csv") + " --method initial ";
  const CommandResult made = render(usual + "--width 64 --video " + video);
  EXPECT_EQ(made.exit_code, 0) << made.errors;
  EXPECT_THAT(made.output, HasSubstr("walk.mp4: 60 frames of 64x32, 2 s, H.264"));
  EXPECT_THAT(run_command("ffprobe -v error -show_streams " + video).output,
              AllOf(HasSubstr("nb_frames=60"), HasSubstr("projection=equirectangular")));
  expect_error(render(usual + "--video " + video), 1, "--video", 3);
  const auto again = render(usual + "--width 64 --fps 60 -f -q --video " + video);
  EXPECT_EQ(again.exit_code, 0) << again.errors;
  fs::remove(video);

  std::vector<std::string> arguments = this->arguments();
  arguments[arguments.size() - 2] = "--video";
  arguments.back() = video;
  int status = 0;
  stop_once(
      arguments, [&] { return directory_.entries() > 2; }, SIGINT, &status);
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_EQ(directory_.entries(), 2U) << "only the room and the table";

  expect_error(run_command("ulimit -f 8; " + joined(arguments) + "-q"), 1, "walk.mp4: ffmpeg", 2);
  expect_error(run_command("PATH=/nowhere " + joined(arguments)), 1, "apt install ffmpeg", 2);
  for (const char* wrong :
       {"--video walk.mp4 --quality 90", "--seconds 3", "--crf 20", "--fps 24", "--quality 90",
        "--video walk.mkv", "--smooth eased --seconds 2 --speed-m-per-s 1"}) {
    expect_error(render(usual + wrong), 2, "--", 2);
  }
}

}  // namespace
}  // namespace raywalk
