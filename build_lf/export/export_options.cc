#include "build_lf/export/export_options.h"

#include <fmt/format.h>

#include <array>

#include "core/base/error.h"
#include "core/files/output_folder.h"

namespace raywalk::build_lf {
namespace {

struct NamedFormat {
  ExportFormat format;
  const char* name;
};
constexpr std::array kFormats{NamedFormat{ExportFormat::kColmap, "colmap"},
                              NamedFormat{ExportFormat::kNerfstudio, "nerfstudio"},
                              NamedFormat{ExportFormat::kFrames, "frames"},
                              NamedFormat{ExportFormat::kPly, "ply"}};

}  // namespace

ExportFormat export_format_from_name(const std::string& name) {
  for (const NamedFormat& known : kFormats) {
    if (name == known.name) return known.format;
  }
  throw UsageError(
      fmt::format("--format {}: unknown; give colmap, nerfstudio, frames or ply", excerpt(name)));
}

std::string name_of(ExportFormat format) {
  for (const NamedFormat& known : kFormats) {
    if (format == known.format) return known.name;
  }
  return "";
}

std::filesystem::path default_export_name(const std::filesystem::path& room, ExportFormat format) {
  const std::string stem =
      std::filesystem::absolute(without_trailing_slash(room)).lexically_normal().stem().string();
  return format == ExportFormat::kPly ? stem + ".ply" : stem + "-" + name_of(format);
}

}  // namespace raywalk::build_lf
