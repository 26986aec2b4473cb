#include "core/report/label_places.h"

#include <gtest/gtest.h>

namespace raywalk {
namespace {

LabelPlaces wide() { return {{0.0, 0.0}, {200.0, 200.0}}; }

TEST(LabelPlacesTest, LabelsKeepClearOfEachOtherAndOfEveryPoint) {
  LabelPlaces places = wide();
  // A point above left of the second, where its label would be.
  const std::vector<PixelPoint> points{{100.0, 100.0}, {110.0, 104.0}};
  for (const PixelPoint point : points) places.add_point(point);
  const auto first = places.place(points[0], "39"), second = places.place(points[1], "34");
  ASSERT_TRUE(first && second);
  EXPECT_FALSE(first->overlaps(*second));
  for (const TextBox& box : {*first, *second}) {
    for (const PixelPoint point : points) {
      EXPECT_FALSE(point.x > box.left && point.x < box.right && point.y < box.baseline &&
                   point.y > box.baseline - kFontPx);
    }
  }
}

TEST(LabelPlacesTest, LinesAreAvoidedWhereThereIsAChoice) {
  LabelPlaces free = wide(), crossed = wide();
  crossed.add_line({{0.0, 90.0}, {100.0, 90.0}, {100.0, 100.0}});
  const auto usual = free.place({100.0, 100.0}, "label"),
             below = crossed.place({100.0, 100.0}, "label");
  ASSERT_TRUE(usual && below);
  EXPECT_LT(usual->baseline, 100.0);
  EXPECT_GT(below->baseline, 100.0);
  for (double y = 0.0; y < 200.0; y += 4.0) crossed.add_line({{0.0, y}, {200.0, y}});
  EXPECT_TRUE(crossed.place({50.0, 50.0}, "label")) << "rather on a line than not at all";
}

TEST(LabelPlacesTest, LabelsStayWithinThePlot) {
  LabelPlaces places = wide();
  for (const PixelPoint corner :
       {PixelPoint{1.0, 1.0}, {199.0, 1.0}, {1.0, 199.0}, {199.0, 199.0}}) {
    const auto box = places.place(corner, "label");
    ASSERT_TRUE(box);
    EXPECT_GE(box->left, 0.0);
    EXPECT_LE(box->right, 200.0);
    EXPECT_LE(box->baseline, 200.0);
    EXPECT_GE(box->baseline, 0.8 * kFontPx);
  }
  EXPECT_FALSE(LabelPlaces({0.0, 0.0}, {20.0, 20.0}).place({10.0, 10.0}, "much too long"));
}

TEST(ReferenceLabelsTest, NeighboursDoNotOverlap) {
  const auto apart = reference_labels({{100.0, "one"}, {300.0, "two"}}, 0.0, 400.0);
  EXPECT_EQ(apart[0].row, 0);
  EXPECT_EQ(apart[1].row, 0);
  EXPECT_FALSE(apart[0].right);
  EXPECT_TRUE(apart[1].right);
  // Two lines close to each other: the labels point away from each other.
  EXPECT_EQ(reference_labels({{200.0, "left one"}, {210.0, "right one"}}, 0.0, 400.0)[1].row, 0);
  // The third has only the place of the second.
  const auto edge =
      reference_labels({{0.0, "LFU"}, {390.0, "near the edge"}, {400.0, "edge"}}, 0.0, 400.0);
  EXPECT_TRUE(edge[0].right);
  EXPECT_FALSE(edge[2].right);
  EXPECT_GT(edge[2].row, edge[1].row);
}

}  // namespace
}  // namespace raywalk
