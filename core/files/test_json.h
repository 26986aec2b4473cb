// For tests: what a JSON document holds.
#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace raywalk {

// Expects the keys of `expected` with its values, in whatever order and beside others.
inline void expect_keys(const nlohmann::json& document, const nlohmann::json& expected) {
  for (const auto& [key, value] : expected.items()) EXPECT_EQ(document.at(key), value) << key;
}

}  // namespace raywalk
