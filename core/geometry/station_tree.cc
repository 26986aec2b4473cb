#include "core/geometry/station_tree.h"

#include <algorithm>
#include <numeric>

namespace raywalk {
namespace {

constexpr int kLargestLeaf = 8;

}  // namespace

StationTree::StationTree(std::vector<Eigen::Vector2d> points)
    : points_(std::move(points)), order_(points_.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  build(0, size());
}

std::vector<int> StationTree::in_order(std::vector<int> indices) {
  std::sort(indices.begin(), indices.end());
  return indices;
}

// Builds the node of a part of order_ and its halves; returns its index. Halves are split at the
// median of the longer side, so equal points do not make the tree deep.
int StationTree::build(int begin, int end) {
  const auto at = static_cast<int>(nodes_.size());
  Node node{.begin = begin, .end = end};
  if (begin < end) node.box.low = node.box.high = point(order_[static_cast<std::size_t>(begin)]);
  for (const int index : indices_of(node)) {
    node.box.low = node.box.low.cwiseMin(point(index));
    node.box.high = node.box.high.cwiseMax(point(index));
  }
  nodes_.push_back(node);
  if (end - begin <= kLargestLeaf) return at;
  const Eigen::Vector2d extent = node.box.high - node.box.low;
  const int longer = extent[0] >= extent[1] ? 0 : 1;
  const int middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](int a, int b) { return point(a)[longer] < point(b)[longer]; });
  build(begin, middle);
  nodes_[static_cast<std::size_t>(at)].right = build(middle, end);
  return at;
}

}  // namespace raywalk
