#include "capture/camera/osc_client.h"

#include <fmt/format.h>
#include <httplib.h>

#include <algorithm>
#include <array>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stop_token>
#include <thread>

#include "capture/base/http_url.h"
#include "core/base/interrupt.h"

namespace raywalk::capture {
namespace {

using Json = nlohmann::json;

constexpr const char* kInfo = "/osc/info";
constexpr const char* kState = "/osc/state";
constexpr const char* kExecute = "/osc/commands/execute";
constexpr const char* kStatus = "/osc/commands/status";

// Headers required by the Open Spherical Camera API (protocol pages of Google and of Insta360).
const httplib::Headers kHeaders = {{"Accept", "*/*"}, {"X-XSRF-Protected", "1"}};
constexpr const char* kJson = "application/json;charset=utf-8";

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

std::string checked_url(const std::string& url) {
  const HttpUrl split = split_url(url);
  const bool has_path = split.path.find_first_not_of('/') != std::string::npos;
  if (is_http_url(url) && !has_path) return split.server;
  throw UsageError("camera.osc.url is " + excerpt(url) +
                   "; it must be an address like http://192.168.1.1");
}

}  // namespace

std::string text_at(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string{};
}

std::optional<double> number_at(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

Json list_at(const Json& object, const std::string& key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_array() ? *found : Json::array();
}

bool OscRefusal::is_temporary() const {
  // Theta: "cannot be executed due to the camera status", "cannot be received temporarily"; Google:
  // cameraInExclusiveUse.
  static const std::array<std::string, 3> passing = {"disabledCommand", "serviceUnavailable",
                                                     "cameraInExclusiveUse"};
  return std::find(passing.begin(), passing.end(), code_) != passing.end();
}

struct OscClient::Reply {
  int status = 0;
  std::string body;
};

// The reply to a command.
struct OscClient::Answer {
  bool done = false;
  std::string id;  // of a command in progress
  Json results;    // an object; empty while in progress

  OscCommand command() const {
    // Level 2; then level 1 as Google and as Ricoh name it.
    for (const char* key : {"fileUrl", "fileUri", "_fileUri"}) {
      std::string file = shown_at(results, key);
      if (!file.empty()) return {done, id, std::move(file)};
    }
    return {done, id, {}};
  }
};

OscClient::OscClient(const OscConfig& config, Clock& clock) : config_(config), clock_(clock) {
  config_.url = checked_url(config.url);
  http_ = std::make_unique<httplib::Client>(config_.url);
  const auto timeout = duration_from_ms(config.connect_timeout_ms);
  http_->set_connection_timeout(timeout);
  http_->set_read_timeout(timeout);
  http_->set_write_timeout(timeout);
  http_->set_keep_alive(true);
  http_->set_tcp_nodelay(true);
}

OscClient::~OscClient() = default;

DeviceFault OscClient::fault(FaultKind kind, const std::string& what,
                             const std::string& path) const {
  return {kind, url() + path + ": " + what};
}

// --- HTTP ----------------------------------------------------------------------------------------

// Posts the JSON text `body`, or gets the path if it is empty. Throws DeviceFault: kNoContact
// without a connection or a complete reply, kWrongDevice if the reply is too long; Interrupted
// while a body arrives. HTTP errors are returned as replies.
OscClient::Reply OscClient::send(const std::string& path, const std::string& body,
                                 bool for_picture) {
  const std::size_t max_bytes = for_picture ? kLargestPicture : kLargestAnswer;
  Reply reply;
  bool too_long = false;
  httplib::Request request;
  request.method = body.empty() ? "GET" : "POST";
  request.path = path;
  request.body = body;
  request.headers = kHeaders;
  if (!body.empty()) request.headers.emplace("Content-Type", kJson);
  request.content_receiver = [&](const char* data, std::size_t length, std::uint64_t,
                                 std::uint64_t) {
    too_long = reply.body.size() + length > max_bytes;
    if (too_long || interrupt_requested()) return false;
    reply.body.append(data, length);
    return true;
  };
  // Ends the request after its total time. httplib's timeouts are per system call, so a server that
  // sends single bytes could delay it without end.
  const double total_ms =
      for_picture ? config_.picture_timeout_ms : 2.0 * config_.connect_timeout_ms;
  std::mutex mutex;
  std::condition_variable_any ended;
  bool late = false;
  std::jthread deadline([&](const std::stop_token& token) {
    std::unique_lock lock(mutex);
    ended.wait_for(lock, token, duration_from_ms(total_ms), [] { return false; });
    if (token.stop_requested()) return;
    late = true;
    http_->stop();
  });
  httplib::Response response;
  httplib::Error error = httplib::Error::Success;
  const bool answered = http_->send(request, response, error);
  deadline.request_stop();
  deadline.join();
  reply.status = response.status;
  if (answered) return reply;
  throw_if_interrupted();
  if (too_long) {
    throw fault(FaultKind::kWrongDevice,
                fmt::format("the answer is longer than {} bytes; check camera.osc.url", max_bytes),
                path);
  }
  if (error == httplib::Error::Connection || error == httplib::Error::ConnectionTimeout) {
    throw fault(FaultKind::kNoContact,
                "no connection to the camera; switch it on, let this computer join its network, "
                "and check camera.osc.url",
                path);
  }
  throw fault(FaultKind::kNoContact,
              fmt::format("no complete reply from the camera within {:g} ms; check that it is near "
                          "and switched on",
                          late ? total_ms : config_.connect_timeout_ms),
              path);
}

OscClient::Reply OscClient::ask(const std::string& path, const std::string& body, Repeat repeat,
                                bool for_picture) {
  for (int attempt = 1;; ++attempt) {
    throw_if_interrupted();
    try {
      Reply reply = send(path, body, for_picture);
      if (for_picture || !reply.body.empty() || reply.status != 200) return reply;
      throw fault(FaultKind::kNoContact, "the camera answers with nothing; switch it off and on",
                  path);
    } catch (const DeviceFault& lost) {
      const bool again = repeat == Repeat::kIfUnanswered && attempt < kAttempts &&
                         lost.kind() == FaultKind::kNoContact;
      if (!again) throw;
      http_->stop();  // the next request opens a new connection
      clock_.sleep(duration_from_ms(kPauseBetweenAttempts_ms));
    }
  }
}

// --- The API -------------------------------------------------------------------------------------

Json OscClient::object_from(const std::string& path, const std::string& body, Repeat repeat) {
  const Reply reply = ask(path, body, repeat, false);
  Json json = Json::parse(reply.body, nullptr, false);
  if (json.is_object()) return json;
  if (reply.status >= 500) {
    throw fault(FaultKind::kNoContact,
                fmt::format("the camera fails with HTTP {}; switch it off and on", reply.status),
                path);
  }
  throw fault(
      FaultKind::kWrongDevice,
      reply.status >= 400
          ? fmt::format("HTTP {}: this is not a camera of the Open Spherical Camera API; check "
                        "camera.osc.url",
                        reply.status)
          : fmt::format("the answer is no JSON object but {}; check camera.osc.url",
                        excerpt(reply.body)),
      path);
}

Json OscClient::info() {
  Json info = object_from(kInfo, "", Repeat::kIfUnanswered);
  if (info.contains("model") || info.contains("manufacturer")) return info;
  throw fault(
      FaultKind::kWrongDevice,
      "names neither manufacturer nor model: " + excerpt(info.dump()) + "; check camera.osc.url",
      kInfo);
}

Json OscClient::state() {
  const Json json = object_from(kState, "{}", Repeat::kIfUnanswered);
  const auto state = json.find("state");
  if (state != json.end() && state->is_object()) return *state;
  throw fault(FaultKind::kWrongDevice,
              "holds no state: " + excerpt(json.dump()) + "; check camera.osc.url", kState);
}

OscClient::Answer OscClient::answer_from(const std::string& path, const Json& request,
                                         Repeat repeat) {
  const Json reply = object_from(path, request.dump(), repeat);
  if (reply.contains("error")) {
    const Json error = object_at(reply, "error");
    throw OscRefusal(shown_at(error, "code"), one_line(shown_at(error, "message")));
  }
  const std::string state = shown_at(reply, "state");
  const std::string id = shown_at(reply, "id");
  if (state == "inProgress" && !id.empty()) return {false, id, Json::object()};
  // At level 1 an answer with results has no state.
  if (state == "done" || (state.empty() && reply.contains("results"))) {
    return {true, {}, object_at(reply, "results")};
  }
  throw fault(FaultKind::kWrongDevice,
              (state == "inProgress" ? "a command in progress without an id: "
                                     : "neither done nor in progress: ") +
                  excerpt(reply.dump()) + "; update the camera's firmware",
              path);
}

OscClient::Answer OscClient::execute(const std::string& name, Json parameters, Repeat repeat) {
  if (!session_id_.empty()) parameters["sessionId"] = session_id_;
  Json request = {{"name", name}};
  if (!parameters.empty()) request["parameters"] = std::move(parameters);
  return answer_from(kExecute, request, repeat);
}

void OscClient::open_session() {
  if (!level_known_) {
    const Json levels = list_at(info(), "apiLevel");
    const bool has_level_2 = std::find(levels.begin(), levels.end(), Json(2)) != levels.end();
    needs_session_ = !has_level_2 || shown_at(state(), "_apiVersion") == "1";
    level_known_ = true;
  }
  if (!needs_session_) return;
  session_id_.clear();
  try {
    session_id_ = shown_at(execute("camera.startSession", Json::object()).results, "sessionId");
    execute("camera.setOptions", {{"options", {{"clientVersion", 2}}}});
    session_id_.clear();
    needs_session_ = false;
  } catch (const OscRefusal& refusal) {
    if (refusal.is_temporary()) {
      throw fault(FaultKind::kBusy, "the camera is in use" + refusal.in_parentheses() +
                                        "; close other programs that use the camera");
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
    return object_at(execute("camera.getOptions", {{"optionNames", wanted}}).results, "options");
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
  execute("camera.setOptions", {{"options", options}});
}

OscCommand OscClient::begin_picture() {
  // A kept connection may have been closed by the server, which is noticed only when a request on
  // it is lost.
  http_->stop();
  return execute("camera.takePicture", Json::object(), Repeat::kNever).command();
}

OscCommand OscClient::status_of(const std::string& id) {
  return answer_from(kStatus, {{"id", id}}, Repeat::kIfUnanswered).command();
}

std::string OscClient::fetch(const std::string& file) {
  // The host in a file's address is the camera's own view, which differs from the configured one
  // behind an access point or a forwarded port.
  const std::string path = needs_session_ ? kExecute : split_url(file).path;
  const Json command = {{"name", "camera.getImage"}, {"parameters", {{"fileUri", file}}}};
  Reply reply = ask(path, needs_session_ ? command.dump() : "", Repeat::kIfUnanswered, true);
  if (reply.status == 200) return std::move(reply.body);
  throw fault(FaultKind::kBadPicture,
              fmt::format("HTTP {} instead of the picture; check the camera's card", reply.status),
              path);
}

}  // namespace raywalk::capture
