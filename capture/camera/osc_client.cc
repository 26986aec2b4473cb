#include "capture/camera/osc_client.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "capture/base/device_fault.h"
#include "capture/base/http_url.h"
#include "core/base/interrupt.h"

namespace raywalk::capture {
namespace {

using Json = nlohmann::json;

constexpr const char* kInfo = "/osc/info";
constexpr const char* kState = "/osc/state";
constexpr const char* kExecute = "/osc/commands/execute";
constexpr const char* kStatus = "/osc/commands/status";

constexpr int kAttempts = 3;
constexpr double kPauseBetweenAttempts_ms = 250.0;
constexpr std::size_t kLargestAnswer = std::size_t{4} << 20;
// More than any camera's panorama: 8 bytes for each pixel of 11008x5504 (Ricoh Theta X) fit in.
constexpr std::size_t kLargestPicture = std::size_t{512} << 20;

// A member that should be an object; an empty object if it is not one.
Json object_at(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_object() ? *found : Json::object();
}

// Text as it is, any other type as JSON.
std::string shown_at(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || found->is_null()) return {};
  return found->is_string() ? found->get<std::string>() : found->dump();
}

// The file named by the results of a picture; empty if none.
std::string file_in(const Json& results) {
  // Level 2; then level 1 as Google and as Ricoh name it.
  for (const char* key : {"fileUrl", "fileUri", "_fileUri"}) {
    std::string file = shown_at(results, key);
    if (!file.empty()) return file;
  }
  return {};
}

void throw_if_refused(const Json& reply) {
  if (!reply.contains("error")) return;
  const Json error = object_at(reply, "error");
  throw OscRefusal(shown_at(error, "code"), one_line(shown_at(error, "message")));
}

bool has_level_2(const Json& info) {
  const auto levels = info.find("apiLevel");
  return levels != info.end() && levels->is_array() &&
         std::find(levels->begin(), levels->end(), Json(2)) != levels->end();
}

}  // namespace

std::string text_at(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string{};
}

std::optional<double> number_at(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

std::optional<std::int64_t> count_at(const nlohmann::json& object, const char* key) {
  constexpr double kLargest = 9007199254740992.0;  // 2^53
  const auto number = number_at(object, key);
  if (!number || !(*number >= 0.0 && *number <= kLargest)) return std::nullopt;
  return static_cast<std::int64_t>(*number);
}

// The reply to a command.
struct OscClient::Answer {
  bool done = false;
  std::string id;  // of a command in progress
  Json results;    // an object; empty while in progress

  OscCommand command() const { return {done, id, file_in(results)}; }
};

bool OscRefusal::is_temporary() const {
  // Theta: "cannot be executed due to the camera status", "cannot be received temporarily"; Google:
  // cameraInExclusiveUse.
  static const std::array<std::string, 3> passing = {"disabledCommand", "serviceUnavailable",
                                                     "cameraInExclusiveUse"};
  return std::find(passing.begin(), passing.end(), code_) != passing.end();
}

OscClient::OscClient(const OscConfig& config, Clock& clock)
    : config_(config), clock_(clock), http_(config.url, config.connect_timeout_ms) {}

HttpReply OscClient::answered(Repeat repeat, const std::function<HttpReply()>& send) {
  for (int attempt = 1;; ++attempt) {
    throw_if_interrupted();
    try {
      return send();
    } catch (const DeviceFault& fault) {
      const bool again = repeat == Repeat::kIfUnanswered && attempt < kAttempts &&
                         fault.kind() == FaultKind::kNoContact;
      if (!again) throw;
      http_.use_fresh_connection();
      clock_.sleep(duration_from_ms(kPauseBetweenAttempts_ms));
    }
  }
}

HttpReply OscClient::post(const std::string& path, const std::string& body) {
  return not_empty(http_.post_json(path, body, 2.0 * config_.connect_timeout_ms, kLargestAnswer),
                   path);
}

HttpReply OscClient::not_empty(HttpReply reply, const std::string& path) const {
  if (!reply.body.empty() || reply.status != 200) return reply;
  throw DeviceFault(FaultKind::kNoContact,
                    url() + path + ": the camera answers with nothing; switch it off and on");
}

Json OscClient::object_in(const HttpReply& reply, const std::string& path) const {
  Json json = Json::parse(reply.body, nullptr, false);
  if (json.is_object()) return json;
  const std::string where = url() + path;
  if (reply.status >= 500) {
    throw DeviceFault(FaultKind::kNoContact,
                      fmt::format("{}: the camera fails with HTTP {}; switch it off and on", where,
                                  reply.status));
  }
  if (reply.status >= 400) {
    throw DeviceFault(FaultKind::kWrongDevice,
                      fmt::format("{}: HTTP {}: this is not a camera of the Open Spherical Camera "
                                  "API; check camera.osc.url",
                                  where, reply.status));
  }
  throw DeviceFault(FaultKind::kWrongDevice,
                    fmt::format("{}: the answer is no JSON object but {}; check camera.osc.url",
                                where, excerpt(reply.body)));
}

Json OscClient::info() {
  const HttpReply reply = answered(Repeat::kIfUnanswered, [this] {
    return not_empty(http_.get(kInfo, 2.0 * config_.connect_timeout_ms, kLargestAnswer), kInfo);
  });
  Json info = object_in(reply, kInfo);
  if (!info.contains("model") && !info.contains("manufacturer")) {
    throw DeviceFault(FaultKind::kWrongDevice, url() + kInfo +
                                                   ": names neither manufacturer nor model: " +
                                                   excerpt(reply.body) + "; check camera.osc.url");
  }
  return info;
}

Json OscClient::state() {
  const HttpReply reply = answered(Repeat::kIfUnanswered, [this] { return post(kState, "{}"); });
  const Json json = object_in(reply, kState);
  if (!json.contains("state") || !json.at("state").is_object()) {
    throw DeviceFault(FaultKind::kWrongDevice, url() + kState + ": holds no state: " +
                                                   excerpt(reply.body) + "; check camera.osc.url");
  }
  return json.at("state");
}

OscClient::Answer OscClient::answer_in(const HttpReply& http_reply, const std::string& path) const {
  const Json reply = object_in(http_reply, path);
  throw_if_refused(reply);
  const std::string state = shown_at(reply, "state");
  if (state == "inProgress") {
    Answer answer{false, shown_at(reply, "id"), Json::object()};
    if (!answer.id.empty()) return answer;
    throw DeviceFault(FaultKind::kWrongDevice,
                      url() + path + ": a command in progress without an id: " +
                          excerpt(reply.dump()) + "; update the camera's firmware");
  }
  // At level 1 an answer with results has no state.
  if (state == "done" || (state.empty() && reply.contains("results"))) {
    return {true, {}, object_at(reply, "results")};
  }
  throw DeviceFault(FaultKind::kWrongDevice,
                    url() + path + ": neither done nor in progress: " + excerpt(reply.dump()) +
                        "; update the camera's firmware");
}

OscClient::Answer OscClient::execute(const std::string& name, Json parameters, Repeat repeat) {
  if (!session_id_.empty()) parameters["sessionId"] = session_id_;
  Json request = {{"name", name}};
  if (!parameters.empty()) request["parameters"] = std::move(parameters);
  const std::string body = request.dump();
  const HttpReply reply = answered(repeat, [&] { return post(kExecute, body); });
  return answer_in(reply, kExecute);
}

void OscClient::open_session() {
  if (!level_known_) {
    needs_session_ = !has_level_2(info()) || shown_at(state(), "_apiVersion") == "1";
    level_known_ = true;
  }
  if (!needs_session_) return;
  session_id_.clear();
  try {
    const Json results =
        execute("camera.startSession", Json::object(), Repeat::kIfUnanswered).results;
    session_id_ = shown_at(results, "sessionId");
    execute("camera.setOptions", {{"options", {{"clientVersion", 2}}}}, Repeat::kIfUnanswered);
    session_id_.clear();
    needs_session_ = false;
  } catch (const OscRefusal& refusal) {
    if (refusal.is_temporary()) {
      throw DeviceFault(FaultKind::kBusy, url() + ": " + refusal.what() + " (" + refusal.code() +
                                              "); close other programs that use the camera");
    }
    // A camera without sessions has level 2; one with sessions but without clientVersion has
    // level 1.
    needs_session_ = !session_id_.empty();
  }
}

Json OscClient::options(const std::vector<std::string>& names) {
  std::vector<std::string> wanted;
  std::copy_if(names.begin(), names.end(), std::back_inserter(wanted),
               [this](const std::string& name) { return !unknown_options_.contains(name); });
  if (wanted.empty()) return Json::object();
  try {
    const Answer answer =
        execute("camera.getOptions", {{"optionNames", wanted}}, Repeat::kIfUnanswered);
    return object_at(answer.results, "options");
  } catch (const OscRefusal& refusal) {
    if (refusal.is_temporary() && wanted.size() == 1) throw;
    if (wanted.size() == 1) {
      unknown_options_.insert(wanted.front());
      return Json::object();
    }
  }
  // A single unknown name makes a camera refuse all: request each option alone.
  Json all = Json::object();
  for (const std::string& name : wanted) all.update(options({name}));
  return all;
}

void OscClient::set_options(const Json& options) {
  // Setting the same values twice is harmless.
  execute("camera.setOptions", {{"options", options}}, Repeat::kIfUnanswered);
}

OscCommand OscClient::begin_picture() {
  http_.use_fresh_connection();
  return execute("camera.takePicture", Json::object(), Repeat::kNever).command();
}

OscCommand OscClient::status_of(const std::string& id) {
  const std::string body = Json{{"id", id}}.dump();
  const HttpReply reply = answered(Repeat::kIfUnanswered, [&] { return post(kStatus, body); });
  return answer_in(reply, kStatus).command();
}

std::string OscClient::fetch(const std::string& file) {
  const bool by_command = needs_session_;
  // The host in a file's address is the camera's own view, which differs from the configured one
  // behind an access point or a forwarded port.
  const std::string path = by_command ? kExecute : split_url(file).path;
  const std::string body =
      Json{{"name", "camera.getImage"}, {"parameters", {{"fileUri", file}}}}.dump();
  HttpReply reply = answered(Repeat::kIfUnanswered, [&] {
    return by_command ? http_.post_json(path, body, config_.picture_timeout_ms, kLargestPicture)
                      : http_.get(path, config_.picture_timeout_ms, kLargestPicture);
  });
  if (reply.status != 200) {
    throw DeviceFault(FaultKind::kBadPicture,
                      fmt::format("{}: HTTP {} instead of the picture; check the camera's card",
                                  url() + path, reply.status));
  }
  if (reply.promised_bytes && *reply.promised_bytes != reply.body.size()) {
    throw DeviceFault(FaultKind::kBadPicture,
                      fmt::format("{}: the picture is truncated, {} of {} bytes; check the "
                                  "connection to the camera",
                                  url() + path, reply.body.size(), *reply.promised_bytes));
  }
  return std::move(reply.body);
}

}  // namespace raywalk::capture
