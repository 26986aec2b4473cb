#include "calibrate/chain/calibration_report.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/files/atomic_output.h"
#include "core/files/image_file.h"
#include "core/files/json.h"
#include "core/report/report.h"

namespace raywalk::calibrate {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int kReportVersion = 1;

// JSON has null for numbers that are not finite.
double number(const ordered_json& value) {
  return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::string shown(const ordered_json& value, int decimals) {
  return number_or_dash(number(value), decimals);
}

int count(const ordered_json& document, const char* key) { return document.at(key).get<int>(); }

std::string lens_numbers(const ordered_json& lens) {
  if (lens.is_null()) return "the lenses of the given file";
  return fmt::format("residual {} px over {} points in {} pictures",
                     shown(lens.at("residual_px"), 2), count(lens, "points"),
                     count(lens, "pictures"));
}

std::string stitch_numbers(const ordered_json& stitch) {
  const ordered_json& seam = stitch.at("seam");
  return fmt::format(
      "{} panoramas of {} x {}, step at the seam {} levels before balancing, {} after",
      count(stitch, "frames"), count(stitch, "width_px"), count(stitch, "height_px"),
      shown(seam.at("step_before_levels"), 1), shown(seam.at("step_after_levels"), 1));
}

std::string mask_numbers(const ordered_json& mask) {
  if (mask.is_null()) return "nothing is masked";
  const double share = number(mask.at("masked_share"));
  std::string text = fmt::format("{:.2f} % of the sphere is masked", 100.0 * share);
  const ordered_json& own = mask.at("frame_masks");
  if (own.is_null()) return text;
  const std::string with_own = fmt::format(
      "{:.2f} % in the {} of {} frames with a mask of their own",
      100.0 * number(own.at("masked_share")), count(own, "frames"), count(own, "of_frames"));
  return share > 0.0 ? fmt::format("{} in all frames, {}", text, with_own)
                     : fmt::format("masked of the sphere: {}", with_own);
}

std::string intersection_numbers(const ordered_json& intersections) {
  if (intersections.empty()) return "no intersections";
  const auto largest = [&](const char* key) {
    double most = 0.0;
    for (const ordered_json& intersection : intersections) {
      if (intersection.contains(key)) most = std::max(most, number(intersection.at(key)));
    }
    return most;
  };
  return fmt::format(
      "largest error at the {} intersections {:.2f} mm and {:.2f} px (W = 4096), by {:.1f} mm and "
      "{:.2f} degrees corrected",
      intersections.size(), largest("position_mm"), largest("rotation_px"),
      largest("correction_mm"), largest("correction_deg"));
}

std::string poses_numbers(const ordered_json& poses) {
  const int keyframes = count(poses, "keyframes"), stations = count(poses, "stations");
  std::string held_out;
  if (const ordered_json& frames = poses.at("held_out"); !frames.is_null()) {
    held_out =
        fmt::format(", {} of {} held-out frames", count(frames, "posed"), count(frames, "frames"));
  }
  return fmt::format(
      "{} of {} stations posed{}{}, residual {} px (W = 4096), positions to {} mm, attitudes to {} "
      "deg; {}",
      count(poses, "posed"), keyframes,
      keyframes < stations ? fmt::format(" ({} in all)", stations) : "", held_out,
      shown(poses.at("residual_px"), 2), shown(poses.at("position_sigma_mm"), 2),
      shown(poses.at("rotation_sigma_deg"), 3), intersection_numbers(poses.at("intersections")));
}

std::string rectify_numbers(const ordered_json& rectify) {
  std::string text = fmt::format("{} frames", count(rectify, "grid_frames"));
  if (const int frames = count(rectify, "validation_frames"); frames > 0) {
    text += fmt::format(", {} for validation", frames);
  }
  if (const std::size_t frames = rectify.at("left_out").size(); frames > 0) {
    text += fmt::format(", {} left out", frames);
  }
  if (const ordered_json& masks = rectify.at("frame_masks"); !masks.is_null()) {
    text += fmt::format(", {} with a mask of their own", count(masks, "frames"));
  }
  return text;
}

// The texts under a key of every step that has it, each after the step's name.
ordered_json texts_of(const ordered_json& documents, const char* key) {
  ordered_json texts = ordered_json::array();
  for (const auto& [step, document] : documents.items()) {
    if (!document.contains(key)) continue;
    for (const ordered_json& text : document.at(key)) {
      texts.push_back(step + ": " + text.get<std::string>());
    }
  }
  return texts;
}

ordered_json trustworthy(const ordered_json& documents) {
  if (!documents.contains("poses")) return nullptr;
  const bool good_lenses =
      !documents.contains("lens") || documents.at("lens").at("warnings").empty();
  return good_lenses && documents.at("poses").at("trustworthy").get<bool>();
}

std::vector<ReportImage> images_of(const ordered_json& documents, const fs::path& out) {
  std::vector<ReportImage> images;
  for (const auto& [step, document] : documents.items()) {
    if (!document.contains("figures")) continue;
    for (const ordered_json& figure : document.at("figures")) {
      const fs::path file = out / figure.at("file").get<std::string>();
      images.push_back(report_image(step, figure.at("row").get<std::string>(),
                                    figure.at("caption").get<std::string>(), read_picture(file)));
    }
  }
  return images;
}

}  // namespace

ordered_json step_document(const Calibration& calibration, CalibrationStep step) {
  const fs::path file = calibration.out() / (step_name(step) + ".json");
  if (!fs::exists(file)) return nullptr;
  try {
    return ordered_json::parse(read_file(file));
  } catch (const nlohmann::json::exception& e) {
    throw Error(file.string() + ": damaged (" + one_line(e.what()) + "); run the step again");
  }
}

std::string step_numbers(CalibrationStep step, const ordered_json& document) {
  switch (step) {
    case CalibrationStep::kLens:
      return lens_numbers(document);
    case CalibrationStep::kStitch:
      return stitch_numbers(document);
    case CalibrationStep::kMask:
      return mask_numbers(document);
    case CalibrationStep::kPoses:
      return poses_numbers(document);
    case CalibrationStep::kRectify:
      return rectify_numbers(document);
  }
  return {};
}

ordered_json write_calibration(const Calibration& calibration, const std::vector<StepRun>& steps,
                               const ordered_json& trade) {
  ordered_json documents = ordered_json::object(), runs = ordered_json::array();
  for (const StepRun& run : steps) {
    const std::string name = step_name(run.step);
    runs.push_back({{"step", name}, {"seconds", run.seconds}, {"reused", run.reused}});
    ordered_json document = step_document(calibration, run.step);
    if (!document.is_null()) documents[name] = std::move(document);
  }
  const CaptureSet& set = calibration.captured();
  ordered_json whole{{"format_version", kReportVersion},
                     {"source", set.source.string()},
                     {"stations", set.stations()},
                     {"trustworthy", trustworthy(documents)},
                     {"warnings", texts_of(documents, "warnings")},
                     {"notes", texts_of(documents, "notes")},
                     {"keyframe_trade", trade},
                     {"steps", runs}};
  const std::vector<ReportImage> images = images_of(documents, calibration.out());
  whole.update(documents);
  write_file_atomically(calibration.out() / "calibration.json", json_text(whole));
  write_file_atomically(calibration.out() / "index.html",
                        report_page("calibration", whole, images));
  return whole;
}

void write_calibration_until(const Calibration& calibration, CalibrationStep last) {
  std::vector<StepRun> runs;
  for (const CalibrationStep step : kCalibrationSteps) {
    const bool left_any = !step_document(calibration, step).is_null();
    if (step <= last && calibration.has(step) && left_any) {
      runs.push_back({step, calibration.seconds(step), step != last});
    }
  }
  write_calibration(calibration, runs, ordered_json::array());
}

void run_reported(Calibration* calibration, CalibrationStep step) {
  calibration->run(step);
  const ordered_json document = step_document(*calibration, step);
  if (document.is_null()) return;
  for (const auto& warning : document.value("warnings", std::vector<std::string>{})) {
    spdlog::warn("{}", warning);
  }
}

}  // namespace raywalk::calibrate
