#include "core/files/yaml_document.h"

#include <gtest/gtest.h>

#include <string>

#include "core/base/error.h"

namespace raywalk {
namespace {

TEST(YamlPlaceOfKey, IsTheLineOfItsValue) {
  const YAML::Node document = load_yaml_document(
      "# a plan\nk_deg: 76\nblend:\n  overlap_deg: 5\nlines:\n  - axis: x\n  - axis: z\n"
      "    at: [1,\n      2]\n",
      "plan.yaml");
  const auto place = [&](const std::string& key) {
    return yaml_place_of_key(document, "plan.yaml", key);
  };
  EXPECT_EQ(place("k_deg"), "plan.yaml:2: ");
  EXPECT_EQ(place("blend.overlap_deg"), "plan.yaml:4: ");
  EXPECT_EQ(place("lines[0].axis"), "plan.yaml:6: ");
  EXPECT_EQ(place("lines[1].axis"), "plan.yaml:7: ");
  EXPECT_EQ(place("lines[1].at[1]"), "plan.yaml:9: ");
  for (const char* missing : {"cells", "blend.k_deg", "k_deg.x", "lines[2].axis", "lines[x].axis",
                              "lines.axis", "blend[0]"}) {
    EXPECT_EQ(place(missing), "plan.yaml: ") << missing;
  }
}

TEST(YamlPlaceOfKey, AnEmptyDocumentHasNoLines) {
  EXPECT_EQ(yaml_place_of_key(load_yaml_document("", "a.yaml"), "a.yaml", "k_deg"), "a.yaml: ");
}

}  // namespace
}  // namespace raywalk
