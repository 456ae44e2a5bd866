// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "cloud/point_cloud.h"

namespace alidade::test {

/// An R-tree packed by sort-tile-recurse (Leutenegger et al. 1997), small enough to read: it shows what
/// another index needs for octree/tree_query.h. Pages of one level are stored one after another, leaves
/// first.
class StrRTree {
 public:
  /// Number of a page.
  using Node = std::size_t;

  /// page_size: points of a leaf and children of a page, at least 2.
  explicit StrRTree(const PointCloud& cloud, std::size_t page_size = 16) : cloud_(cloud) {
    for (std::size_t id = 0; id < cloud.size(); ++id) ids_.push_back(id);
    tile(0, ids_.size(), 0, page_size);
    for (std::size_t begin = 0; begin < ids_.size(); begin += page_size) {
      Page page{.first = begin, .count = std::min(page_size, ids_.size() - begin), .leaf = true};
      for (std::size_t i = begin; i < begin + page.count; ++i) page.bounds.grow(cloud.world(ids_[i]));
      pages_.push_back(page);
    }
    for (std::size_t level = 0; pages_.size() - level > 1;) {
      const std::size_t end = pages_.size();
      for (std::size_t begin = level; begin < end; begin += page_size) {
        Page page{.first = begin, .count = std::min(page_size, end - begin), .leaf = false};
        for (std::size_t i = begin; i < begin + page.count; ++i) page.bounds.grow(pages_[i].bounds);
        pages_.push_back(page);
      }
      level = end;
    }
  }

  bool empty() const { return pages_.empty(); }
  Node root() const { return pages_.size() - 1; }
  const Bounds& bounds(Node node) const { return pages_[node].bounds; }

  template <class Visit>
  void for_each_point(Node node, const Visit& visit) const {
    const Page& page = pages_[node];
    for (std::size_t i = page.first; page.leaf && i < page.first + page.count; ++i) {
      if (!visit(ids_[i], cloud_.world(ids_[i]))) return;
    }
  }

  template <class Visit>
  void for_each_child(Node node, const Visit& visit) const {
    const Page& page = pages_[node];
    for (std::size_t i = page.first; !page.leaf && i < page.first + page.count; ++i) visit(i);
  }

 private:
  struct Page {
    Bounds bounds{};
    std::size_t first = 0, count = 0;  ///< of the ids of a leaf, of the pages below otherwise
    bool leaf = true;
  };

  /// Sorts by x into slabs, these by y into runs, these by z.
  void tile(std::size_t begin, std::size_t end, int axis, std::size_t page_size) {
    std::sort(
        ids_.begin() + static_cast<std::ptrdiff_t>(begin), ids_.begin() + static_cast<std::ptrdiff_t>(end),
        [&](std::uint64_t a, std::uint64_t b) { return cloud_.world(a)[axis] < cloud_.world(b)[axis]; });
    if (axis == 2) return;
    const double pages = std::ceil(static_cast<double>(end - begin) / static_cast<double>(page_size));
    const double slabs = std::ceil(std::pow(pages, 1.0 / (3 - axis)));
    const std::size_t step = page_size * static_cast<std::size_t>(std::ceil(std::max(pages / slabs, 1.0)));
    for (std::size_t i = begin; i < end; i += step) tile(i, std::min(i + step, end), axis + 1, page_size);
  }

  const PointCloud& cloud_;
  std::vector<std::uint64_t> ids_;
  std::vector<Page> pages_;
};

}  // namespace alidade::test
