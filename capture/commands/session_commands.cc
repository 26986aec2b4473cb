// status, verify, import, export: the commands that work on a session on disk.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "capture/commands/commands.h"
#include "capture/import/import.h"
#include "capture/session/merge_sessions.h"
#include "capture/session/session_frames.h"
#include "capture/session/session_status.h"
#include "core/base/escaped.h"
#include "core/command_line/command_options.h"

namespace raywalk::capture {
namespace {

struct SessionArguments {
  std::string directory{};
  bool json = false;
  bool give_up = false;
  ExportOptions exported{};
};

struct ImportArguments {
  std::string session{};
  std::vector<std::filesystem::path> files{};
  std::string first_station{};
  std::string video{};
  VideoImportOptions frames{};
};

std::shared_ptr<SessionArguments> add_session(CLI::App* command) {
  auto arguments = std::make_shared<SessionArguments>();
  command->add_option("session", arguments->directory, "Session directory")->required();
  return arguments;
}

void import_files(const ImportArguments& arguments) {
  SystemClock clock;
  if (arguments.video.empty() && arguments.files.empty()) {
    throw CLI::RequiredError("pictures, or --video");
  }
  const ImportResult result =
      arguments.video.empty()
          ? import_pictures(arguments.session, arguments.files, arguments.frames.allow_missing,
                            &clock, arguments.first_station)
          : import_video(arguments.session, arguments.video, arguments.frames, &clock);
  fmt::print("{}\n", result.summary);
}

void verify(const SessionArguments& arguments) {
  SessionReader session(arguments.directory);
  const SessionVerification verification = verify_session(&session);
  fmt::print("{}", verification_text(verification));
  if (!arguments.give_up || verification.is_whole()) {
    require_no_faults(verification.faults, arguments.directory);
    return;
  }
  SystemClock clock;
  fmt::print("{}\n", give_up_lost_stations(verification, arguments.directory, &clock));
}

}  // namespace

void add_status(CLI::App* app) {
  CLI::App* command =
      app->add_subcommand("status", "Show the progress of a session and the next step");
  auto arguments = add_session(command);
  command->add_flag("--json", arguments->json, "Print JSON; docs/session.md lists the fields");
  command->footer("Example:\n  raywalk-capture status hall");
  command->callback([arguments] {
    SessionReader session(arguments->directory);
    const nlohmann::json status = session_status(&session);
    if (arguments->json) {
      fmt::print("{}\n", status.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
    } else {
      fmt::print("{}", status_text(status));
    }
  });
}

void add_verify(CLI::App* app) {
  CLI::App* command =
      app->add_subcommand("verify", "Compare every frame of a session with its checksum");
  auto arguments = add_session(command);
  command->add_flag("--give-up", arguments->give_up,
                    "Count the stations of missing and changed frames as not captured, so that "
                    "run or import brings them again");
  command->footer("Example:\n  raywalk-capture verify hall");
  command->callback([arguments] { verify(*arguments); });
}

void add_import(CLI::App* app) {
  CLI::App* command = app->add_subcommand(
      "import", "Import pictures from the camera's card, or a video, into a session");
  auto arguments = std::make_shared<ImportArguments>();
  command->add_option("session", arguments->session, "Session directory")->required();
  CLI::Option* files =
      command->add_option("files", arguments->files, "Pictures, or directories that hold them");
  command->add_flag("--allow-missing", arguments->frames.allow_missing,
                    "Import the matched pictures even if some stations or pictures have no match");
  command
      ->add_option("--station", arguments->first_station,
                   "Assign the pictures, in order of their names and whatever their times, to the "
                   "stations from this one on in the order of capture")
      ->type_name("NAME")
      ->needs(files);
  CLI::Option* video =
      command->add_option("--video", arguments->video, "A video shot while the slider moved slowly")
          ->excludes(files);
  command
      ->add_option("--line", arguments->frames.line,
                   "The line that the video shows (default: detect it)")
      ->type_name("NAME")
      ->needs(video);
  command
      ->add_option("--format", arguments->frames.format,
                   "Format of the frames extracted from a video: jpg or png")
      ->check(one_of({"jpg", "png"}))
      ->needs(video);
  command->footer(
      "Example:\n  raywalk-capture import hall /media/card/DCIM\n"
      "  raywalk-capture import hall R0005.JPG --station x1_004\n"
      "  raywalk-capture import hall --video x0.mp4 --line x0\n"
      "The given files are not modified.");
  add_resumption(command);
  command->callback([arguments] { import_files(*arguments); });
}

void add_export(CLI::App* app) {
  CLI::App* command = app->add_subcommand(
      "export", "Write poses.csv, and gt.csv of validation lines, into a session");
  auto arguments = add_session(command);
  command
      ->add_option("--exposure", arguments->exported.exposure,
                   "Index of the bracketed exposure, from 0")
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--partial", arguments->exported.partial, "Export an unfinished session");
  command->add_flag("--unstitched", arguments->exported.unstitched,
                    "Export fisheye frames that are not stitched to panoramas yet");
  command->footer(
      "Example:\n  raywalk-capture export hall\n"
      "  raywalk-build-lf pack --frames hall/poses.csv --out hall.lf");
  command->callback([arguments] {
    SessionReader session(arguments->directory);
    fmt::print("{}\n", escaped(export_session(&session, arguments->exported)));
  });
}

void add_merge(CLI::App* app) {
  CLI::App* command = app->add_subcommand(
      "merge", "Make one session of several that captured lines of the same plan");
  auto options = std::make_shared<MergeOptions>();
  command->add_option("sessions", options->sessions, "Session directories")->required();
  command->add_option("-o,--out", options->out, "Session directory to create")->required();
  command->add_flag("--replace", options->replace,
                    "Of a line in several sessions, take the one captured last");
  command->add_flag("--partial", options->partial,
                    "Accept lines that no session has, and unfinished ones");
  command->footer(
      "Example:\n  raywalk-capture merge monday tuesday --out hall\n"
      "  raywalk-capture merge hall x3-again --replace --out hall-2\n"
      "The given sessions are not modified; frames are linked where the disk allows it.");
  add_resumption(command);
  command->callback([options] {
    SystemClock clock;
    fmt::print("{}\n", merge_sessions(*options, &clock));
  });
}

}  // namespace raywalk::capture
