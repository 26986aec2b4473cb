// End-to-end test of raywalk-render.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/files/image_file.h"
#include "tests/end_to_end/run_command.h"
#include "tests/synthetic_room/synthetic_room.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

class RenderTest : public ::testing::Test {
 protected:
  static CommandResult render(const std::string& arguments) {
    return run_command(std::string(RAYWALK_RENDER) + " " + arguments);
  }
  std::string room() const { return (directory_ / "room.lf").string(); }
  std::string file(const std::string& name) const { return (directory_ / name).string(); }
  void make_room(const SyntheticRoomSpec& spec) const { write_synthetic_room(spec, room()); }
  std::string view(const std::string& rest) const { return "view " + room() + " " + rest; }
  std::string view_to_png(const std::string& rest) const {
    return view(rest + " --out " + file("view.png"));
  }

  // Expects failure with nothing but one error line, and only `left` entries in the directory.
  void expect_error(const CommandResult& result, int exit_code, const std::string& text,
                    size_t left = 1) const {
    expect_one_error(result, exit_code, text);
    EXPECT_THAT(result.errors, ::testing::StartsWith("raywalk-render: error: "));
    EXPECT_EQ(std::count(result.errors.begin(), result.errors.end(), '\n'), 1) << result.errors;
    EXPECT_EQ(directory_.entries(), left);
  }

  static CommandResult run(const std::vector<std::string>& arguments) {
    return run_command(fmt::format("{}", fmt::join(arguments, " ")));
  }
  static nlohmann::json json_in(const fs::path& path) {
    return nlohmann::json::parse(read_file(path));
  }
  // By Ctrl-C, as soon as a file exists.
  static void expect_interrupted_once_there(const std::vector<std::string>& arguments,
                                            const fs::path& awaited) {
    EXPECT_EQ(exit_code_when_stopped(arguments, SIGINT, [&] { return fs::exists(awaited); }), 130);
  }

  TestDirectory directory_;
};

class RenderViewTest : public RenderTest {
 protected:
  RenderViewTest() { make_room(spec_); }

  const SyntheticRoomSpec spec_{.overhang_m = 0.25, .width = 64};
};

TEST_F(RenderViewTest, RendersAViewAndReportsItsSettings) {
  EXPECT_THAT(expect_success(render(view_to_png("--at -0.1,0.2 --method two-sided --k 76"))).output,
              AllOf(HasSubstr(file("view.png")), HasSubstr("64x32 at -0.1,0.2 m"),
                    HasSubstr("two-sided, hybrid at k = 76 degrees")));
  EXPECT_EQ(read_panorama(file("view.png")).cols, 64);
}

TEST_F(RenderViewTest, SettingsFileAndFlags) {
  std::ofstream(file("view.yaml")) << "connection: lfu\nwidth_px: 16\n";
  const CommandResult done = expect_success(
      render(view_to_png("--at=0.1,0.1 --width 32 --settings " + file("view.yaml"))));
  EXPECT_THAT(done.output, AllOf(HasSubstr("32x16"), HasSubstr("lfu at k = 45")));
}

TEST_F(RenderViewTest, TwoEyesAtAHeightOfTheirOwn) {
  const CommandResult done = expect_success(
      render(view_to_png("--at -0.1 0.05 0.2 --stereo ods --ipd-mm 60 --yaw-deg 90")));
  EXPECT_THAT(done.output,
              HasSubstr("64x64, ods, left eye above right eye, 60 mm apart, at -0.1,0.05,0.2 m"));
  EXPECT_EQ(read_picture(file("view.png")).rows, 64);
}

TEST_F(RenderViewTest, RefusesWhatEyesCannotSee) {
  const std::vector<std::pair<std::string, std::string>> refused{
      {"--at 0,0 --ipd-mm 60", "give --stereo ods"},
      {"--at 0,0 --stereo ods --fov-deg 90", "leave out --fov-deg"},
      {"--at 0,0 --stereo ods --pitch-deg 10", "pitch and roll must be 0"},
      {"--at 0,0 --stereo ods --ipd-mm 0.5", "--ipd-mm"},
      {"--at 0,0 --stereo anaglyph", "--stereo"},
      {"--at 0,0.1,0 --method initial", "leave the height out"}};
  for (const auto& [flags, message] : refused) {
    expect_error(render(view_to_png(flags)), 2, message);
  }
  expect_error(render(view_to_png("--at 0.49,0 --stereo ods")), 1,
               "choose a viewpoint farther inside");
}

TEST_F(RenderViewTest, ViewsAreCorrectedByDefaultAndMayBeJpeg) {
  EXPECT_THAT(render(view("--at 0,0 --out " + file("view.jpg"))).output, HasSubstr("hlf-vd"));
  EXPECT_EQ(read_panorama(file("view.jpg")).cols, 64);
}

TEST_F(RenderTest, ASingleLineRendersWithTheRestMarked) {
  make_room({.cells_z = 0, .overhang_m = 0.5, .width = 64});
  EXPECT_THAT(expect_success(render(view_to_png("--at 0,-0.25"))).output,
              HasSubstr("% empty: no line serves it"));
}

TEST_F(RenderViewTest, WrongUsageHasADifferentExitCodeThanFailure) {
  expect_error(render(view_to_png("--at 0.1")), 2, "--at");
  expect_error(render(view_to_png("--at 0,zero")), 2, "--at");
  expect_error(render(view_to_png("--at 0,0 --connection lfu --k 76")), 2, "k = 45");
  expect_error(render(view_to_png("--at 0,0 --k 30")), 2, "45");
  expect_error(render(view_to_png("--at 0,0 --width 30")), 2, "multiple of 4");
  expect_error(render(view_to_png("--at 0,0 --colour red")), 2, "unknown flag");
  expect_error(render(view_to_png("--at 0,0 --method best")), 2, "--method");
  expect_error(render(view("--at 0,0 --out " + file("view.gif"))), 2, ".png");
  expect_error(render("view " + room()), 2, "--at");
  expect_error(render("connect-error " + room() + " --k-list 30"), 2, "45..90");
}

TEST_F(RenderViewTest, UnknownKeyInSettings) {
  std::ofstream(file("view.yaml")) << "method: hlf-vd\noverlap_dge: 5\n";
  expect_error(render(view_to_png("--at 0,0 --settings " + file("view.yaml"))), 2,
               "view.yaml:2: unknown key 'overlap_dge'; did you mean 'overlap_deg'?", 2);
}

TEST_F(RenderTest, AMissingRoomAndUnwritableOutputAreNamed) {
  expect_error(render(view_to_png("--at 0,0")), 1, "room.lf", 0);
  expect_error(render(view("--at 0,0 --out " + file("missing/view.png"))), 1, "missing", 0);
}

TEST_F(RenderViewTest, DamagedRoomsAndPlacesOutsideAreNamed) {
  expect_error(render(view_to_png("--at 0.7,0")), 1, "outside every cell");
  const fs::path volume = directory_ / "room.lf" / "lines" / "x0.h5";
  fs::resize_file(volume, fs::file_size(volume) / 2);
  expect_error(render(view_to_png("--at 0,0")), 1, "x0.h5");
}

TEST_F(RenderTest, WithoutDistancesTheDepthCommandIsNamed) {
  make_room({.width = 64, .distances = false});
  expect_error(render(view_to_png("--at 0,0")), 1, "raywalk-build-lf pack --distance");
  expect_error(render(view_to_png("--at 0,0 --method two-sided")), 1, "two-sided");
  EXPECT_EQ(render(view_to_png("--at 0,0 --method initial")).exit_code, 0);
}

TEST_F(RenderViewTest, AFullDiskLeavesNothing) {
  // A file size limit (here 512 bytes) makes a write fail partway, as a full disk does.
  const CommandResult result = run_command("ulimit -f 1; " + std::string(RAYWALK_RENDER) + " " +
                                           view_to_png("--at 0,0 --width 256"));
  expect_error(result, 1, "view.png");
}

TEST_F(RenderViewTest, ConnectErrorPrintsATable) {
  const CommandResult done = expect_success(render("connect-error " + room() +
                                                   " --method initial,hlf-vd --viewpoints 3"
                                                   " --k-list 45,80,90"));
  EXPECT_THAT(done.output,
              AllOf(HasSubstr("initial views"), HasSubstr("hlf-vd views"), HasSubstr(" 45  lfu"),
                    HasSubstr(" 80  hybrid"), HasSubstr(" 90  rayspace360"), HasSubstr("given")));
  const CommandResult viewed = render(view_to_png("--at 0,0 --method initial"));
  EXPECT_THAT(viewed.output, HasSubstr("k = 90 degrees (the default)"));
}

TEST_F(RenderTest, ErrorModelWritesItsReport) {
  const std::string command = "error-model --viewpoints 7 --report " + file("fig11");
  EXPECT_THAT(expect_success(render(command)).output, HasSubstr("1.5"));
  EXPECT_TRUE(fs::exists(directory_ / "fig11" / "index.html"));
}

// In a file that a stopped run left, behind its checksum; 0 without one.
std::size_t kept_results(const fs::path& partial) {
  std::ifstream file(partial);
  std::string checksum;
  if (!std::getline(file, checksum)) return 0;
  return nlohmann::json::parse(file).size();
}

// With a true view.
class RenderReportTest : public RenderViewTest {
 protected:
  RenderReportTest() {
    write_image(file("truth.png"), render_truth(spec_, {0.1, 0.2}, 64));
    std::ofstream(file("gt.csv")) << "file,x,y,z\ntruth.png,0.1,0,0.2\n";
  }
};

TEST_F(RenderReportTest, ValidatesAgainstTruth) {
  expect_error(render("validate " + room()), 2, "--truth is required", 3);
  const std::string command = "validate " + room() + " --truth " + file("gt.csv") + " --report " +
                              file("report") + " --viewpoints 2";
  EXPECT_THAT(expect_success(render(command)).output,
              AllOf(HasSubstr("initial"), HasSubstr("distances in use: given"),
                    HasSubstr("report/index.html")));
  EXPECT_TRUE(fs::exists(directory_ / "report" / "index.html"));
  const auto json = json_in(directory_ / "report" / "metrics.json");
  EXPECT_EQ(json["views"].size(), 3U);
  EXPECT_EQ(json["views"][0]["name"], "truth");

  std::ofstream(file("gt.csv")) << "file,x,y,z\ntruth.png,0.1,0,0.2\ntruth.png,2,0,0\n";
  fs::remove_all(directory_ / "report");
  expect_error(render(command), 1, "gt.csv:3", 3);
}

TEST_F(RenderReportTest, ValidationsAreStoppedAnyhowAndResumed) {
  std::string list = "file,x,y,z\n";
  for (int i = 0; i < 8; ++i) {
    const double x_m = -0.35 + 0.1 * i;
    write_image(file(fmt::format("truth{}.png", i)), render_truth(spec_, {x_m, 0.2}, 256));
    list += fmt::format("truth{}.png,{},0,0.2\n", i, x_m);
  }
  write_file_atomically(file("gt.csv"), list);
  const std::vector<std::string> command{RAYWALK_RENDER, "validate",     room(), "--truth",
                                         file("gt.csv"), "--viewpoints", "2",    "--report",
                                         file("report")};
  const fs::path partial = file("report/validation.partial");
  const auto kept = [&] { return kept_results(partial); };
  std::size_t before = 0;
  for (const int signal : {SIGKILL, SIGTERM, SIGINT}) {
    EXPECT_EQ(exit_code_when_stopped(command, signal, [&] { return kept() > before; }),
              signal == SIGKILL ? 128 + SIGKILL : 130);
    EXPECT_GT(kept(), before);
    EXPECT_FALSE(fs::exists(file("report/metrics.json")));
    before = kept();
  }
  EXPECT_THAT(expect_success(run(command)).errors,
              HasSubstr(fmt::format("validation.partial: {} results", before)));
  EXPECT_FALSE(fs::exists(partial));
  const auto resumed = json_in(file("report/metrics.json"));
  expect_success(run(command));
  const auto whole = json_in(file("report/metrics.json"));
  EXPECT_EQ(resumed["quarters"], whole["quarters"]);
  EXPECT_EQ(resumed["connection_error"], whole["connection_error"]);
}

TEST_F(RenderReportTest, TradesAreInterruptedByCtrlCAndResumed) {
  const std::vector<std::string> command{RAYWALK_RENDER, "trade",         room(), "--truth",
                                         file("gt.csv"), "--repetitions", "5",    "--report",
                                         file("trade")};
  const fs::path partial = file("trade/trade.partial");
  expect_interrupted_once_there(command, partial);
  const std::size_t kept = kept_results(partial);
  EXPECT_GE(kept, 1U);
  EXPECT_FALSE(fs::exists(file("trade/trade.json")));

  const CommandResult resumed = expect_success(run(command));
  EXPECT_THAT(resumed.output, AllOf(HasSubstr("PSNR dB"), HasSubstr("index.html")));
  const std::size_t left = json_in(file("trade/trade.json"))["settings"].size() - kept;
  EXPECT_THAT(resumed.errors, HasSubstr(fmt::format("trade: {0} of {0} settings (100 %)", left)));
  EXPECT_FALSE(fs::exists(partial));
}

TEST_F(RenderViewTest, SettingsAreChosenByPresetAndByMeasuredTrade) {
  const auto chosen = [&](const std::string& by) {
    return render(view_to_png("--at 0.1,0.2 " + by));
  };
  EXPECT_THAT(expect_success(chosen("--preset accurate")).output,
              AllOf(HasSubstr("preset accurate: "), HasSubstr("two-sided")));
  expect_error(chosen("--budget-ms 1000"), 1, "run raywalk-render trade on it first", 2);

  const std::string trade = "trade " + room() + " --held-out 4 --repetitions 1 --report ";
  EXPECT_THAT(expect_success(render(trade + file("trade"))).output, HasSubstr("preset fast"));
  EXPECT_THAT(expect_success(chosen("--budget-ms 100000")).output,
              AllOf(HasSubstr("the best within 100000 ms"),
                    HasSubstr("(of the setting that trade measured)")));
  expect_error(chosen("--min-psnr-db 99"), 1, "reaches 99 dB", 3);
  expect_error(chosen("--budget-ms nan"), 2, "--budget-ms", 3);
  expect_error(chosen("--preset best"), 2, "--preset", 3);
}

// A path with enough views to be interrupted midway.
class RenderPathTest : public RenderViewTest {
 protected:
  static constexpr std::size_t kViews = 60;
  RenderPathTest() {
    std::ofstream list(file("path.csv"));
    list << "name,x,z\n";
    for (std::size_t i = 0; i < kViews; ++i)
      list << fmt::format("view{},{},0.1\n", i, 0.4 - 0.01 * i);
  }
  std::vector<std::string> arguments() const {
    return {RAYWALK_RENDER, "path",    room(), file("path.csv"), "--method",
            "initial",      "--width", "1024", "--out",          file("views")};
  }
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
  expect_interrupted_once_there(arguments(), file("views/view1.png"));
  const size_t before = pictures();
  EXPECT_GE(before, 2U);
  EXPECT_LT(before, kViews);

  EXPECT_THAT(expect_success(run(arguments())).output,
              HasSubstr(fmt::format("{} of them rendered now", kViews - before)));
  EXPECT_EQ(pictures(), kViews);
}

TEST_F(RenderPathTest, OtherSettingsAreRefused) {
  std::ofstream(file("path.csv")) << "name,x,z\na,0,0\n";
  std::vector<std::string> arguments = this->arguments();
  expect_success(run(arguments));
  arguments.insert(arguments.end(), {"--overlap-deg", "9"});
  expect_error(run(arguments), 1, "overlap_deg", 3);
}

TEST_F(RenderPathTest, AVideoIsWholeOrNothing) {
  const std::string video = file("walk.mp4");
  const std::string usual = "path " + room() + " " + file("path.csv") + " --method initial ";
  EXPECT_THAT(expect_success(render(usual + "--width 64 --video " + video)).output,
              HasSubstr("walk.mp4: 60 frames of 64x32, 2 s, H.264"));
  EXPECT_THAT(run_command("ffprobe -v error -show_streams " + video).output,
              AllOf(HasSubstr("nb_frames=60"), HasSubstr("projection=equirectangular")));
  expect_error(render(usual + "--video " + video), 1, "--video", 3);
  expect_success(render(usual + "--width 64 --fps 60 -f -q --video " + video));
  fs::remove(video);

  std::vector<std::string> arguments = this->arguments();
  arguments[arguments.size() - 2] = "--video";
  arguments.back() = video;
  EXPECT_EQ(exit_code_when_stopped(arguments, SIGINT, [&] { return directory_.entries() > 2; }),
            130);
  EXPECT_EQ(directory_.entries(), 2U) << "only the room and the table";

  const std::string command = fmt::format("{}", fmt::join(arguments, " "));
  expect_error(run_command("ulimit -f 8; " + command + " -q"), 1, "walk.mp4: ffmpeg", 2);
  expect_error(run_command("PATH=/nowhere " + command), 1, "apt install ffmpeg", 2);
  for (const char* wrong :
       {"--video walk.mp4 --quality 90", "--seconds 3", "--crf 20", "--fps 24", "--quality 90",
        "--video walk.mkv", "--smooth eased --seconds 2 --speed-m-per-s 1"}) {
    expect_error(render(usual + wrong), 2, "--", 2);
  }
}

}  // namespace
}  // namespace raywalk
