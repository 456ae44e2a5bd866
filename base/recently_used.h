// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <unordered_map>
#include <utility>

namespace alidade {

/// Values by key, in the order of their last use, for caches that keep the latest ones. Cost: constant. Not
/// thread safe.
template <class Key, class Value, class Hash = std::hash<Key>>
class RecentlyUsed {
 public:
  RecentlyUsed() = default;
  RecentlyUsed(const RecentlyUsed&) = delete;
  RecentlyUsed& operator=(const RecentlyUsed&) = delete;

  /// The value of a key, or null. It becomes the most recently used one.
  Value* find(const Key& key) {
    const auto found = entries_.find(key);
    if (found == entries_.end()) return nullptr;
    order_.splice(order_.begin(), order_, found->second);
    return &found->second->second;
  }

  /// Adds a value as the most recently used one. Requires: the key has none.
  Value& add(const Key& key, Value value) {
    order_.emplace_front(key, std::move(value));
    entries_.emplace(key, order_.begin());
    return order_.front().second;
  }

  /// Takes the least recently used value out. Requires: there is one.
  Value take_oldest() {
    Value oldest = std::move(order_.back().second);
    entries_.erase(order_.back().first);
    order_.pop_back();
    return oldest;
  }

  std::size_t size() const { return order_.size(); }

  /// Keys and values, the most recently used first.
  const std::list<std::pair<Key, Value>>& entries() const { return order_; }

 private:
  std::list<std::pair<Key, Value>> order_;
  std::unordered_map<Key, typename std::list<std::pair<Key, Value>>::iterator, Hash> entries_;
};

}  // namespace alidade
