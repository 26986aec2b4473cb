#include "core/files/json_text.h"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace raywalk {
namespace {

TEST(JsonText, KeepsWhatJsonCannotHoldReadable) {
  nlohmann::ordered_json document{{"z", 1}, {"a", std::numeric_limits<double>::infinity()}};
  document["file"] = "\xff.png";
  EXPECT_EQ(json_text(document), "{\n  \"z\": 1,\n  \"a\": null,\n  \"file\": \"\ufffd.png\"\n}\n");
}

}  // namespace
}  // namespace raywalk
