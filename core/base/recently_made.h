// A cache of what is made on demand, so that memory does not grow with how much is asked for.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "core/base/parallel.h"

namespace raywalk {

// Keeps the `capacity` values that were used last. Can be used by several threads at once; a value
// lives as long as a caller holds it.
template <typename Key, typename Value>
class RecentlyMade {
 public:
  using Made = std::shared_ptr<const Value>;

  RecentlyMade(std::size_t capacity, std::function<Value(const Key&)> make)
      : capacity_(capacity), make_(std::move(make)) {}

  Made get(const Key& key) { return get_all({&key, 1}).front(); }

  // In the order of the keys. What is missing is made in parallel.
  std::vector<Made> get_all(std::span<const Key> keys) {
    std::vector<Made> values;
    values.reserve(keys.size());
    for (const Key& key : keys) values.push_back(used(key, nullptr));
    parallel_for(0, static_cast<int>(keys.size()), 1, [&](int begin, int end) {
      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
        if (values[i] != nullptr) continue;
        values[i] = used(keys[i], std::make_shared<const Value>(make_(keys[i])));
      }
    });
    return values;
  }

 private:
  // What is kept of the key or else `made`, null for nothing; from now on it is kept, as the last.
  Made used(const Key& key, Made made) {
    const std::lock_guard lock(mutex_);
    const auto known = std::ranges::find(kept_, key, &std::pair<Key, Made>::first);
    if (known != kept_.end()) {
      made = known->second;
      kept_.erase(known);
    }
    if (made == nullptr) return made;
    kept_.emplace_front(key, made);
    if (kept_.size() > capacity_) kept_.pop_back();
    return made;
  }

  std::size_t capacity_;
  std::function<Value(const Key&)> make_;
  std::mutex mutex_;
  std::list<std::pair<Key, Made>> kept_;  // the latest first
};

}  // namespace raywalk
