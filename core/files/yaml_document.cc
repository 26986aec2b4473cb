#include "core/files/yaml_document.h"

#include <spdlog/fmt/fmt.h>
#include <yaml-cpp/eventhandler.h>

#include <algorithm>
#include <sstream>

#include "core/base/error.h"
#include "core/files/words.h"

namespace raywalk {
namespace {

// Records the start of the last document and ignores its content.
class DocumentStart : public YAML::EventHandler {
 public:
  YAML::Mark mark() const { return mark_; }

  void OnDocumentStart(const YAML::Mark& mark) override { mark_ = mark; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t,
                const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}

 private:
  YAML::Mark mark_;
};

// YAML::Load drops whatever follows the first document, and YAML::LoadAll of yaml-cpp 0.7 never
// returns from some malformed texts ("{a: 1}, d}": it finds one more empty document again and
// again), so the parser reads at most two documents.
void require_single_document(const std::string& yaml, const std::string& source) {
  std::istringstream stream(yaml);
  YAML::Parser parser(stream);
  DocumentStart start;
  if (parser.HandleNextDocument(start) && parser.HandleNextDocument(start)) {
    throw UsageError(yaml_place(source, start.mark()) +
                     "text after the settings, which must be a single YAML document");
  }
}

// The child node for one part of a key ("blend", ".overlap_deg" or "[2]"); undefined if missing.
YAML::Node child_of(const YAML::Node& node, std::string_view part) {
  if (part.starts_with('[')) {
    const auto index = parse_whole_number(part.substr(1, part.size() - 2));
    return node.IsSequence() && index ? node[*index] : YAML::Node(YAML::NodeType::Undefined);
  }
  if (part.starts_with('.')) part.remove_prefix(1);
  return node.IsMap() ? node[std::string(part)] : YAML::Node(YAML::NodeType::Undefined);
}

}  // namespace

YAML::Node load_yaml_document(std::string_view yaml, const std::string& source) {
  try {
    const std::string text(yaml);
    require_single_document(text, source);
    return YAML::Load(text);
  } catch (const YAML::Exception& e) {
    throw UsageError(yaml_place(source, e.mark) + "not valid YAML (" + one_line(e.msg) + ")");
  }
}

std::string yaml_place(const std::string& source, const YAML::Mark& mark) {
  // yaml-cpp counts lines from 0.
  return mark.is_null() ? source + ": " : fmt::format("{}:{}: ", source, mark.line + 1);
}

std::string yaml_place_of_key(const YAML::Node& document, const std::string& source,
                              std::string_view key) {
  YAML::Node node = document;
  while (!key.empty()) {
    const std::size_t end = std::min(key.find_first_of(".[", 1), key.size());
    const YAML::Node child = child_of(node, key.substr(0, end));
    if (!child.IsDefined()) return source + ": ";
    node.reset(child);  // assigning would change the document
    key.remove_prefix(end);
  }
  return node.IsNull() ? source + ": " : yaml_place(source, node.Mark());
}

}  // namespace raywalk
