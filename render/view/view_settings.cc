#include "render/view/view_settings.h"

#include <fmt/format.h>

#include <set>
#include <stdexcept>
#include <vector>

#include "core/base/error.h"
#include "core/files/settings.h"
#include "core/files/shipped_configs.h"

namespace raywalk::render {
namespace {

// A key for every parameter, which sets its member of the options.
void bind_parameters(ViewOptions* options, SettingsSchema* schema) {
  for (const ViewParameter& parameter : kViewParameters) {
    const bool takes_quoted =
        parameter.value.kind == ParameterKind::kChoice || parameter.zero != nullptr;
    schema->scalar(
        parameter.key,
        [options, &parameter](const std::string& text) {
          parameter.value.set(options, value_of(parameter, text));
        },
        [options, &parameter] { return text_of(parameter, parameter.value.get(*options)); },
        takes_quoted);
  }
}

SettingsSchema schema_of(ViewSettings* settings) {
  std::vector<std::string> presets{"none"};
  presets.insert(presets.end(), kPresets.begin(), kPresets.end());
  SettingsSchema schema;
  schema.choice("preset", &settings->preset, presets)
      .choice("connection", &settings->connection, {kConnections.begin(), kConnections.end()});
  bind_parameters(&settings->options, &schema);
  return schema;
}

template <typename T>
void override_with(const std::optional<T>& flag, T* value) {
  if (flag) *value = *flag;
}

void override_with(const std::map<std::string, std::string>& flags, ViewOptions* options) {
  for (const auto& [key, text] : flags) {
    const ViewParameter& parameter = parameter_of(key);
    try {
      parameter.value.set(options, value_of(parameter, text));
    } catch (const std::invalid_argument& e) {
      throw UsageError(fmt::format("{} is {}; it {}", parameter.flag, excerpt(text), e.what()));
    }
  }
}

// The k of the settings. Throws UsageError where one that is not the default contradicts the
// connection.
double k_deg_of(const ViewSettings& settings) {
  const ViewParameter& k = parameter_of("k_deg");
  const double k_deg = settings.options.k_deg;
  if (settings.connection == "hybrid") return k_deg;
  const double own_k_deg = settings.connection == "lfu" ? k.least : k.most;
  if (k_deg != default_of(k) && k_deg != own_k_deg) {
    throw UsageError(fmt::format("connection {} is k = {} degrees, but k is {}; use hybrid",
                                 settings.connection, own_k_deg, k_deg));
  }
  return own_k_deg;
}

}  // namespace

ViewSettings view_settings(const ViewFlags& flags, const ViewSettings& base) {
  ViewSettings settings = base;
  if (flags.settings) {
    schema_of(&settings).load(named_config(*flags.settings, ConfigKind::kView, "--settings"));
    try {
      k_deg_of(settings);
    } catch (const UsageError& e) {
      throw UsageError(flags.settings->string() + ": " + e.what());
    }
  }
  // A connection named on the command line uses its own k: the file's k belongs to the file's
  // connection.
  const bool other_connection = flags.connection && *flags.connection != settings.connection;
  if (other_connection && !flags.parameters.contains("k_deg")) {
    settings.options.k_deg = default_of(parameter_of("k_deg"));
  }
  override_with(flags.preset, &settings.preset);
  override_with(flags.connection, &settings.connection);
  override_with(flags.parameters, &settings.options);
  k_deg_of(settings);
  return settings;
}

ViewMode view_mode(const ViewSettings& settings) {
  ViewMode mode{.options = settings.options, .connection = settings.connection};
  mode.options.k_deg = k_deg_of(settings);
  const bool is_default = mode.options.k_deg == default_of(parameter_of("k_deg"));
  mode.k_source = settings.connection != "hybrid" ? "fixed by the connection"
                  : is_default                    ? "the default"
                                                  : "given";
  return mode;
}

std::vector<ViewMode> view_modes(ViewSettings settings, std::vector<std::string> methods,
                                 const Room& room) {
  if (methods.empty()) {
    methods = {"initial"};
    if (room.has_distances()) methods.insert(methods.end(), {"hlf-vd", "two-sided"});
  }
  if (std::set(methods.begin(), methods.end()).size() != methods.size()) {
    throw UsageError("a method is named twice; name each once");
  }
  std::vector<ViewMode> modes;
  for (const std::string& method : methods) {
    settings.options.method = method_from_name(method);
    modes.push_back(view_mode(settings));
  }
  return modes;
}

}  // namespace raywalk::render
