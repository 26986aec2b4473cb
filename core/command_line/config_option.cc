#include "core/command_line/config_option.h"

#include <CLI/CLI.hpp>
#include <utility>

namespace raywalk {
namespace {

// The kinds that a command line can name; registers of sliders are named by captures.
constexpr std::pair<ConfigKind, const char*> kTypeNames[] = {
    {ConfigKind::kCapture, "CAPTURE-CONFIG"},
    {ConfigKind::kRig, "RIG-CONFIG"},
    {ConfigKind::kVirtualRoom, "ROOM-CONFIG"},
    {ConfigKind::kView, "VIEW-CONFIG"},
    {ConfigKind::kLens, "LENS-CONFIG"}};

}  // namespace

CLI::Option* takes_config(CLI::Option* option, ConfigKind kind) {
  for (const auto& [named, type_name] : kTypeNames) {
    if (named == kind) option->type_name(type_name);
  }
  return option;
}

std::optional<ConfigKind> config_kind_of(const std::string& type_name) {
  for (const auto& [kind, named] : kTypeNames) {
    if (type_name == named) return kind;
  }
  return std::nullopt;
}

}  // namespace raywalk
