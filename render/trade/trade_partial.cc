#include "render/trade/trade_partial.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "core/base/error.h"
#include "core/files/atomic_output.h"
#include "render/trade/trade_json.h"

namespace raywalk::render {
namespace {

using nlohmann::ordered_json;

constexpr const char* kFormat = "raywalk-trade-partial";
constexpr int kPartialFormatVersion = 1;

std::string key_of(const TradeSetting& setting) { return parameters_of(setting).dump(); }

}  // namespace

TradePartial::TradePartial(std::filesystem::path file, const std::string& input)
    : file_(std::move(file)),
      content_(
          std::make_unique<ordered_json>(ordered_json{{"format", kFormat},
                                                      {"format_version", kPartialFormatVersion},
                                                      {"input", input},
                                                      {"settings", ordered_json::array()}})) {
  const AtomicFile probe(file_);
  if (std::filesystem::exists(file_)) read();
}

TradePartial::~TradePartial() = default;

void TradePartial::read() {
  try {
    ordered_json earlier = ordered_json::parse(read_file(file_));
    for (const char* key : {"format", "format_version", "input"}) {
      if (earlier.at(key) != content_->at(key)) {
        throw Error(file_.string() +
                    " belongs to another room, truth or sweep; remove it, or use another --report");
      }
    }
    for (const ordered_json& setting : earlier.at("settings")) {
      measured_[setting.at("dials").dump()] = measurement_from(setting.at("measured"));
    }
    *content_ = std::move(earlier);
  } catch (const nlohmann::json::exception&) {
    throw Error(file_.string() + ": not as raywalk-render trade writes it; remove it");
  }
}

std::optional<TradeMeasurement> TradePartial::find(const TradeSetting& setting) const {
  const auto found = measured_.find(key_of(setting));
  if (found == measured_.end()) return std::nullopt;
  return found->second;
}

void TradePartial::add(const TradeSetting& setting, const TradeMeasurement& measured) {
  measured_[key_of(setting)] = measured;
  (*content_)["settings"].push_back(
      {{"dials", parameters_of(setting)}, {"measured", json_of(measured)}});
  write_file_atomically(
      file_,
      content_->dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

}  // namespace raywalk::render
