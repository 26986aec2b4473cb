#include "core/http/request_target.h"

#include <gtest/gtest.h>

#include "core/http/test_fault.h"

namespace raywalk {
namespace {

std::string path_of(std::string_view target) { return parse_request_target(target).path; }

int fault_of_target(std::string_view target) {
  return fault_of([&] { parse_request_target(target); });
}

TEST(RequestTarget, HasAPathAndParameters) {
  const RequestTarget target =
      parse_request_target("/a/b.jpg?x=-1.5&name=two+words%21&&empty=&bare");
  EXPECT_EQ(target.path, "/a/b.jpg");
  ASSERT_EQ(target.query.size(), 4U);
  EXPECT_EQ(parameter_of(target, "x"), "-1.5");
  EXPECT_EQ(parameter_of(target, "name"), "two words!");
  EXPECT_EQ(parameter_of(target, "empty"), "");
  EXPECT_EQ(parameter_of(target, "bare"), "");
  EXPECT_EQ(parameter_of(target, "y"), std::nullopt);
  EXPECT_EQ(path_of("/"), "/");
  EXPECT_EQ(path_of("/?"), "/");
  EXPECT_EQ(path_of("/a/"), "/a/");
  EXPECT_EQ(path_of("/a%20b%41%c3%a4"), "/a bA\xc3\xa4");
  // Dots that are part of a name.
  EXPECT_EQ(path_of("/..a/b.../.c"), "/..a/b.../.c");
}

TEST(RequestTarget, DecodesOnce) { EXPECT_EQ(path_of("/%252e%252e/a"), "/%2e%2e/a"); }

TEST(RequestTarget, RefusesWhatLeavesTheRoot) {
  for (const char* target :
       {"/..",          "/../a",    "/a/../b", "/a/..",         "/.",      "/./a",
        "/%2e%2e/a",    "/%2E./a",  "/.%2e",   "/a/%2e%2e%2fb", "/..%2fa", "/%2fetc/passwd",
        "//etc/passwd", "//host/a", "/a//b",   "/..\\a",        "/..%5ca", "/a%5c..%5cb",
        "/a%00.jpg",    "/%00",     "/a%0ab",  "/a%7f"}) {
    EXPECT_EQ(fault_of_target(target), 400) << target;
  }
}

TEST(RequestTarget, RefusesOtherFormsAndBadEscapes) {
  for (const char* target :
       {"", "*", "a", "?x=1", "http://localhost/a", "localhost:80", "/a#b", "/a b", "/%", "/%2",
        "/%g0", "/%0g", "/%-1", "/?%", "/?a=%f", "/?%zz=1"}) {
    EXPECT_EQ(fault_of_target(target), 400) << target;
  }
}

TEST(RequestTarget, HasFewParameters) {
  std::string query = "/?";
  for (std::size_t i = 0; i < kMostQueryParameters; ++i) query += "a=1&";
  EXPECT_EQ(fault_of_target(query), 0);
  EXPECT_EQ(fault_of_target(query + "b"), 400);
}

TEST(RequestTarget, TakesAParameterOnce) {
  std::string message;
  const RequestTarget target = parse_request_target("/?x=1&%78=2");
  EXPECT_EQ(fault_of([&] { parameter_of(target, "x"); }, &message), 400);
  EXPECT_NE(message.find("parameter x"), std::string::npos) << message;
}

TEST(RequestTarget, LosesAParameter) {
  const auto without = [](std::string_view target) {
    return target_without(parse_request_target(target), "token");
  };
  EXPECT_EQ(without("/?token=1"), "/");
  EXPECT_EQ(without("/a%20b?x=%31&token=1&y=+"), "/a%20b?x=%31&y=+");
  EXPECT_EQ(without("/?t%6fken=1&tokens=2&token"), "/?tokens=2");
}

}  // namespace
}  // namespace raywalk
