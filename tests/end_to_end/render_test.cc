// End-to-end test of raywalk-render.
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/files/image_file.h"
#include "tests/end_to_end/render_command.h"

namespace raywalk {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

TEST_F(RenderTest, RendersAViewAndReportsItsSettings) {
  make_room();
  const CommandResult result = render(view_to_png("--at -0.1,0.2 --method two-sided --k 76"));
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, AllOf(HasSubstr(file("view.png")), HasSubstr("64x32 at -0.1,0.2 m"),
                                   HasSubstr("two-sided, hybrid at k = 76 degrees")));
  EXPECT_EQ(read_panorama(file("view.png")).cols, 64);
}

TEST_F(RenderTest, ViewIsCorrectedByDefault) {
  make_room();
  EXPECT_THAT(render(view_to_png("--at 0,0")).output, HasSubstr("hlf-vd"));
  EXPECT_THAT(render(view_to_png("--at 0,0 --method initial")).output, HasSubstr("initial"));
}

TEST_F(RenderTest, SettingsFileAndFlags) {
  make_room();
  std::ofstream(file("view.yaml")) << "connection: lfu\nwidth_px: 16\n";
  const CommandResult result =
      render(view_to_png("--at=0.1,0.1 --width 32 --settings " + file("view.yaml")));
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, AllOf(HasSubstr("32x16"), HasSubstr("lfu at k = 45")));
}

TEST_F(RenderTest, TwoEyesAtAHeightOfTheirOwn) {
  make_room();
  const CommandResult result =
      render(view_to_png("--at -0.1 0.05 0.2 --stereo ods --ipd-mm 60 --yaw-deg 90"));
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output,
              HasSubstr("64x64, ods, left eye above right eye, 60 mm apart, at -0.1,0.05,0.2 m"));
  EXPECT_EQ(read_picture(file("view.png")).rows, 64);
}

TEST_F(RenderTest, RefusesWhatEyesCannotSee) {
  make_room();
  const std::vector<std::pair<std::string, std::string>> refused{
      {"--at 0,0 --ipd-mm 60", "give --stereo ods"},
      {"--at 0,0 --stereo ods --fov-deg 90", "leave out --fov-deg"},
      {"--at 0,0 --stereo ods --pitch-deg 10", "pitch and roll must be 0"},
      {"--at 0,0 --stereo ods --ipd-mm 0.5", "--ipd-mm"},
      {"--at 0,0 --stereo anaglyph", "--stereo"},
      {"--at 0,0.1,0 --method initial", "leave the height out"}};
  for (const auto& [flags, message] : refused) {
    const CommandResult result = render(view_to_png(flags));
    EXPECT_EQ(result.exit_code, 2) << flags;
    EXPECT_THAT(result.errors, HasSubstr(message)) << flags;
    EXPECT_FALSE(fs::exists(file("view.png"))) << flags;
  }
  const CommandResult outside = render(view_to_png("--at 0.49,0 --stereo ods"));
  EXPECT_EQ(outside.exit_code, 1);
  EXPECT_THAT(outside.errors, HasSubstr("choose a viewpoint farther inside"));
}

TEST_F(RenderTest, WritesJpegToo) {
  make_room();
  EXPECT_EQ(render(view("--at 0,0 --out " + file("view.jpg"))).exit_code, 0);
  EXPECT_EQ(read_panorama(file("view.jpg")).cols, 64);
}

TEST_F(RenderTest, ASingleLineRendersWithTheRestMarked) {
  make_room({.cells_z = 0, .overhang_m = 0.5, .width = 64});
  const CommandResult result = render(view_to_png("--at 0,-0.25"));
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, HasSubstr("% empty: no line serves it"));
}

TEST_F(RenderTest, HelpHasAnExampleForEveryCommand) {
  EXPECT_EQ(render("--version").exit_code, 0);
  for (const std::string command : {"view", "path", "validate", "connect-error", "error-model"}) {
    const CommandResult help = render(command + " --help");
    EXPECT_EQ(help.exit_code, 0) << command;
    EXPECT_THAT(help.output, HasSubstr("raywalk-render " + command + " ")) << command;
  }
}

TEST_F(RenderTest, WrongUsageHasADifferentExitCodeThanFailure) {
  make_room();
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

TEST_F(RenderTest, UnknownKeyInSettings) {
  make_room();
  std::ofstream(file("view.yaml")) << "method: hlf-vd\noverlap_dge: 5\n";
  expect_error(render(view_to_png("--at 0,0 --settings " + file("view.yaml"))), 2,
               "view.yaml:2: unknown key 'overlap_dge'; did you mean 'overlap_deg'?", 2);
}

TEST_F(RenderTest, ViewpointOutsideEveryCell) {
  make_room();
  expect_error(render(view_to_png("--at 0.7,0")), 1, "outside every cell");
}

TEST_F(RenderTest, MissingRoom) { expect_error(render(view_to_png("--at 0,0")), 1, "room.lf", 0); }

TEST_F(RenderTest, ManifestOfANewerFormat) {
  make_room();
  const fs::path manifest = directory_ / "room.lf" / "manifest.json";
  auto json = nlohmann::json::parse(read_file(manifest));
  json["format_version"] = 4;
  std::ofstream(manifest) << json.dump();
  expect_error(render(view_to_png("--at 0,0")), 1, "manifest.json");
}

TEST_F(RenderTest, TruncatedVolume) {
  make_room();
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

TEST_F(RenderTest, UnwritableOutputIsDetectedBeforeTheRoomIsRead) {
  expect_error(render(view("--at 0,0 --out " + file("missing/view.png"))), 1, "missing", 0);
}

TEST_F(RenderTest, AFullDiskLeavesNothing) {
  make_room();
  // A file size limit (here 512 bytes) makes a write fail partway, as a full disk does.
  const CommandResult result = run_command("ulimit -f 1; " + std::string(RAYWALK_RENDER) + " " +
                                           view_to_png("--at 0,0 --width 256"));
  expect_error(result, 1, "view.png");
}

TEST_F(RenderTest, ConnectErrorPrintsATable) {
  make_room();
  const CommandResult measured = render("connect-error " + room() +
                                        " --method initial,hlf-vd --viewpoints 3"
                                        " --k-list 45,80,90");
  EXPECT_EQ(measured.exit_code, 0) << measured.errors;
  EXPECT_THAT(measured.output,
              AllOf(HasSubstr("initial views"), HasSubstr("hlf-vd views"), HasSubstr(" 45  lfu"),
                    HasSubstr(" 80  hybrid"), HasSubstr(" 90  rayspace360"), HasSubstr("given")));
  const CommandResult viewed = render(view_to_png("--at 0,0 --method initial"));
  EXPECT_THAT(viewed.output, HasSubstr("k = 90 degrees (the default)"));
}

TEST_F(RenderTest, ErrorModelWritesItsReport) {
  const CommandResult result = render("error-model --viewpoints 7 --report " + file("fig11"));
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_TRUE(fs::exists(directory_ / "fig11" / "index.html"));
  EXPECT_THAT(result.output, HasSubstr("1.5"));
}

// In a file that a stopped run left, behind its checksum; 0 without one.
std::size_t kept_results(const fs::path& partial) {
  std::ifstream file(partial);
  std::string checksum;
  if (!std::getline(file, checksum)) return 0;
  return nlohmann::json::parse(file).size();
}

TEST_F(RenderTest, ValidatesAgainstTruth) {
  const SyntheticRoomSpec spec{.overhang_m = 0.25, .width = 64};
  make_room(spec);
  write_image(file("truth.png"), render_truth(spec, {0.1, 0.2}, 64));
  std::ofstream(file("gt.csv")) << "file,x,y,z\ntruth.png,0.1,0,0.2\n";
  expect_error(render("validate " + room()), 2, "--truth is required", 3);
  const std::string command = "validate " + room() + " --truth " + file("gt.csv") + " --report " +
                              file("report") + " --viewpoints 2";
  const CommandResult result = render(command);
  EXPECT_EQ(result.exit_code, 0) << result.errors;
  EXPECT_THAT(result.output, AllOf(HasSubstr("initial"), HasSubstr("distances in use: given"),
                                   HasSubstr("report/index.html")));
  EXPECT_TRUE(fs::exists(directory_ / "report" / "index.html"));
  const auto json = nlohmann::json::parse(read_file(directory_ / "report" / "metrics.json"));
  EXPECT_EQ(json["views"].size(), 3U);
  EXPECT_EQ(json["views"][0]["name"], "truth");

  std::ofstream(file("gt.csv")) << "file,x,y,z\ntruth.png,0.1,0,0.2\ntruth.png,2,0,0\n";
  fs::remove_all(directory_ / "report");
  expect_error(render(command), 1, "gt.csv:3", 3);
}

TEST_F(RenderTest, ValidationsAreStoppedAnyhowAndResumed) {
  const SyntheticRoomSpec spec{.overhang_m = 0.25, .width = 64};
  make_room(spec);
  std::ofstream list(file("gt.csv"));
  list << "file,x,y,z\n";
  for (int i = 0; i < 8; ++i) {
    const double x_m = -0.35 + 0.1 * i;
    const std::string name = "truth" + std::to_string(i) + ".png";
    write_image(file(name), render_truth(spec, {x_m, 0.2}, 256));
    list << name << "," << x_m << ",0,0.2\n";
  }
  list.close();
  const std::vector<std::string> command{RAYWALK_RENDER, "validate",     room(), "--truth",
                                         file("gt.csv"), "--viewpoints", "2",    "--report",
                                         file("report")};
  const fs::path partial = file("report/validation.partial");
  const auto kept = [&] { return kept_results(partial); };
  std::size_t before = 0;
  for (const int signal : {SIGKILL, SIGTERM, SIGINT}) {
    int status = 0;
    stop_once(
        command, [&] { return kept() > before; }, signal, &status);
    EXPECT_EQ(WIFEXITED(status), signal != SIGKILL);
    EXPECT_GT(kept(), before);
    EXPECT_FALSE(fs::exists(file("report/metrics.json")));
    before = kept();
  }
  const CommandResult resumed = run_command(joined(command));
  EXPECT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_THAT(resumed.errors,
              HasSubstr("validation.partial: " + std::to_string(before) + " results"));
  EXPECT_FALSE(fs::exists(partial));
  const auto resumed_json = nlohmann::json::parse(std::ifstream(file("report/metrics.json")));
  EXPECT_EQ(run_command(joined(command)).exit_code, 0);
  const auto whole = nlohmann::json::parse(std::ifstream(file("report/metrics.json")));
  EXPECT_EQ(resumed_json["quarters"], whole["quarters"]);
  EXPECT_EQ(resumed_json["connection_error"], whole["connection_error"]);
}

TEST_F(RenderTest, TradesAreInterruptedByCtrlCAndResumed) {
  make_room();
  write_image(file("truth.png"), render_truth({.overhang_m = 0.25}, {0.1, 0.2}, 64));
  std::ofstream(file("gt.csv")) << "file,x,y,z\ntruth.png,0.1,0,0.2\n";
  const std::vector<std::string> command{RAYWALK_RENDER, "trade",         room(), "--truth",
                                         file("gt.csv"), "--repetitions", "5",    "--report",
                                         file("trade")};
  const fs::path partial = file("trade/trade.partial");
  interrupt_once_there(command, partial);
  const std::size_t kept = kept_results(partial);
  EXPECT_GE(kept, 1U);
  EXPECT_FALSE(fs::exists(file("trade/trade.json")));

  const CommandResult resumed = run_command(joined(command));
  EXPECT_EQ(resumed.exit_code, 0) << resumed.errors;
  EXPECT_THAT(resumed.output, AllOf(HasSubstr("PSNR dB"), HasSubstr("index.html")));
  const auto settings = nlohmann::json::parse(std::ifstream(file("trade/trade.json")))["settings"];
  const std::string measured_now = "trade: " + std::to_string(settings.size() - kept) + " of " +
                                   std::to_string(settings.size() - kept) + " settings (100 %)";
  EXPECT_THAT(resumed.errors, HasSubstr(measured_now));
  EXPECT_FALSE(fs::exists(partial));
}

TEST_F(RenderTest, SettingsAreChosenByPresetAndByMeasuredTrade) {
  make_room();
  const std::string view = "view " + room() + " --at 0.1,0.2 --out " + file("view.png") + " ";
  const CommandResult preset = render(view + "--preset accurate");
  EXPECT_EQ(preset.exit_code, 0) << preset.errors;
  EXPECT_THAT(preset.output, AllOf(HasSubstr("preset accurate: "), HasSubstr("two-sided")));
  expect_error(render(view + "--budget-ms 1000"), 1, "run raywalk-render trade on it first", 2);

  const CommandResult trade =
      render("trade " + room() + " --held-out 4 --repetitions 1 --report " + file("trade"));
  ASSERT_EQ(trade.exit_code, 0) << trade.errors;
  EXPECT_THAT(trade.output, HasSubstr("preset fast"));
  const CommandResult chosen = render(view + "--budget-ms 100000");
  EXPECT_EQ(chosen.exit_code, 0) << chosen.errors;
  EXPECT_THAT(chosen.output, HasSubstr("the best within 100000 ms"));
  EXPECT_THAT(chosen.output, HasSubstr("(of the setting that trade measured)"));
  expect_error(render(view + "--min-psnr-db 99"), 1, "reaches 99 dB", 3);
  expect_error(render(view + "--budget-ms nan"), 2, "--budget-ms", 3);
  expect_error(render(view + "--preset best"), 2, "--preset", 3);
}

TEST_F(RenderTest, TradeRefusesInvalidTruthBeforeAnyWork) {
  make_room();
  const std::string command =
      "trade " + room() + " --truth " + file("gt.csv") + " --report " + file("trade");
  expect_error(render(command), 1, "gt.csv");
}

}  // namespace
}  // namespace raywalk
