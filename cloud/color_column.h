// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <iterator>
#include <span>
#include <vector>

#include "cloud/attributes.h"

namespace alidade {

/// A colour of 8 bits per channel. With a factor it represents the Color16 of its values times the factor.
using Color8 = glm::u8vec3;

/// Colours by point id, in memory of any owner: a span of Color16, or of Color8 if all are multiples of one
/// factor, as index files store colours of 8 bits.
class ColorColumn {
 public:
  ColorColumn() = default;
  // Implicit, as the other columns take spans and vectors.
  ColorColumn(std::span<const Color16> colors)  // NOLINT(google-explicit-constructor)
      : deep_(colors.data()), size_(colors.size()) {}
  ColorColumn(const std::vector<Color16>& colors)  // NOLINT(google-explicit-constructor)
      : ColorColumn(std::span(colors)) {}
  ColorColumn(std::span<const Color8> colors, std::uint16_t factor)
      : shallow_(colors.data()), factor_(factor), size_(colors.size()) {}

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  Color16 operator[](std::size_t id) const {
    return shallow_ == nullptr ? deep_[id] : Color16(shallow_[id]) * factor_;
  }
  ColorColumn subspan(std::size_t first, std::size_t count) const {
    return shallow_ == nullptr ? ColorColumn(deep().subspan(first, count))
                               : ColorColumn(shallow().subspan(first, count), factor_);
  }

  /// The colours as stored in memory; one of the two spans is empty.
  std::span<const Color16> deep() const { return {deep_, deep_ == nullptr ? 0 : size_}; }
  std::span<const Color8> shallow() const { return {shallow_, shallow_ == nullptr ? 0 : size_}; }

  /// The factor of Color8; 1 for Color16.
  std::uint16_t factor() const { return factor_; }

  class Iterator {
   public:
    using iterator_category = std::input_iterator_tag;
    using value_type = Color16;
    using difference_type = std::ptrdiff_t;
    using pointer = void;
    using reference = Color16;

    Iterator() = default;
    Iterator(const ColorColumn& column, std::size_t id) : column_(&column), id_(id) {}
    Color16 operator*() const { return (*column_)[id_]; }
    Iterator& operator++() {
      ++id_;
      return *this;
    }
    Iterator operator++(int) { return {*column_, id_++}; }
    bool operator==(const Iterator& other) const { return id_ == other.id_; }

   private:
    const ColorColumn* column_ = nullptr;
    std::size_t id_ = 0;
  };
  /// The column must outlive them.
  Iterator begin() const { return {*this, 0}; }
  Iterator end() const { return {*this, size_}; }

 private:
  const Color16* deep_ = nullptr;
  const Color8* shallow_ = nullptr;
  std::uint16_t factor_ = 1;
  std::size_t size_ = 0;
};

}  // namespace alidade
