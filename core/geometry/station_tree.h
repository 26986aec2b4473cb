// A k-d tree of plan points, to find those in a region without visiting all. Used by find_grid
// (grid.h) and where neighbours of stations are looked for.
//
// J. L. Bentley, "Multidimensional binary search trees used for associative searching", 1975.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace raywalk {

// An axis-parallel box that just holds the points of a node.
struct PlanBox {
  Eigen::Vector2d low{0, 0};
  Eigen::Vector2d high{0, 0};

  // Of each coordinate, the smallest and largest distance of a point of the box from `from`.
  Eigen::Vector2d least_apart(const Eigen::Vector2d& from) const {
    return (low - from).cwiseMax(from - high).cwiseMax(0.0);
  }
  Eigen::Vector2d most_apart(const Eigen::Vector2d& from) const {
    return (low - from).cwiseAbs().cwiseMax((high - from).cwiseAbs());
  }
};

class StationTree {
 public:
  explicit StationTree(std::vector<Eigen::Vector2d> points);

  const Eigen::Vector2d& point(int index) const { return points_[static_cast<std::size_t>(index)]; }
  int size() const { return static_cast<int>(points_.size()); }
  // The diagonal of the box around all points.
  double extent() const { return (nodes_.front().box.high - nodes_.front().box.low).norm(); }

  // The points, in ascending order, that `accept(index)` takes, among those of the boxes that
  // `may_hold(box)` takes; it must take every box with such a point.
  template <typename MayHold, typename Accept>
  std::vector<int> find(const MayHold& may_hold, const Accept& accept) const {
    std::vector<int> found;
    visit(0, may_hold, [&](std::span<const int> indices) {
      for (const int index : indices) {
        if (accept(index)) found.push_back(index);
      }
    });
    return in_order(std::move(found));
  }

  // The distance to the nearest of these points; infinite if there is none.
  template <typename MayHold, typename Accept>
  double nearest(const Eigen::Vector2d& from, const MayHold& may_hold, const Accept& accept) const {
    double least = std::numeric_limits<double>::infinity();
    const auto may_hold_nearer = [&](const PlanBox& box) {
      return box.least_apart(from).norm() <= least && may_hold(box);
    };
    visit_from(from, 0, may_hold_nearer, [&](std::span<const int> indices) {
      for (const int index : indices) {
        const double distance = (point(index) - from).norm();
        if (distance < least && accept(index)) least = distance;
      }
    });
    return least;
  }

 private:
  struct Node {
    PlanBox box{};
    int begin = 0, end = 0;  // of order_
    int right = 0;           // node of the second half; the first half's follows this; 0: a leaf
  };

  static std::vector<int> in_order(std::vector<int> indices);
  int build(int begin, int end);
  std::span<const int> indices_of(const Node& node) const {
    return std::span(order_).subspan(static_cast<std::size_t>(node.begin),
                                     static_cast<std::size_t>(node.end - node.begin));
  }

  template <typename MayHold, typename Leaf>
  void visit(int at, const MayHold& may_hold, const Leaf& leaf) const {
    const Node& node = nodes_[static_cast<std::size_t>(at)];
    if (!may_hold(node.box)) return;
    if (node.right == 0) return leaf(indices_of(node));
    visit(at + 1, may_hold, leaf);
    visit(node.right, may_hold, leaf);
  }

  // The nearer half first, so that the other can be left out.
  template <typename MayHold, typename Leaf>
  void visit_from(const Eigen::Vector2d& from, int at, const MayHold& may_hold,
                  const Leaf& leaf) const {
    const Node& node = nodes_[static_cast<std::size_t>(at)];
    if (!may_hold(node.box)) return;
    if (node.right == 0) return leaf(indices_of(node));
    const auto away = [&](int half) {
      return nodes_[static_cast<std::size_t>(half)].box.least_apart(from).squaredNorm();
    };
    const bool right_first = away(node.right) < away(at + 1);
    visit_from(from, right_first ? node.right : at + 1, may_hold, leaf);
    visit_from(from, right_first ? at + 1 : node.right, may_hold, leaf);
  }

  std::vector<Eigen::Vector2d> points_;
  std::vector<int> order_;  // the points' indices, node by node
  std::vector<Node> nodes_;
};

}  // namespace raywalk
