// Things that are one where something joins two of them: frames, points.
#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

namespace raywalk::calibrate {

// Union-find with path halving, over 0 to count - 1. At first each is a set of its own.
class DisjointSets {
 public:
  explicit DisjointSets(int count) : parent_(static_cast<std::size_t>(count)) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  // The member that stands for the set; the same for all of a set.
  int root(int member) {
    while (at(member) != member) member = at(member) = at(at(member));
    return member;
  }
  void join(int a, int b) { at(root(a)) = root(b); }

 private:
  int& at(int member) { return parent_[static_cast<std::size_t>(member)]; }
  std::vector<int> parent_;
};

}  // namespace raywalk::calibrate
