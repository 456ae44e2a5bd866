// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "base/error.h"
#include "cloud/cloud_reader.h"
#include "cloud/lattice.h"

namespace alidade::test {

using Opener = std::unique_ptr<CloudReader> (*)(InputFile, Damage);

/// Reads one file with one reader, as read_cloud() does it but without looking at the content first.
inline PointCloud read_alone(Opener open, InputFile file, AttributeSet wanted = AttributeSet::all()) {
  const auto reader = open(std::move(file), Damage::reject);
  const CoordinateSurvey survey = reader->survey({});
  PointCloud cloud;
  cloud.lattice = fit_lattice({&survey, 1});
  reader->rest();
  cloud.files = reader->read(cloud, wanted, {}, {}).files;
  EXPECT_EQ(cloud.size(), survey.finite_count);
  EXPECT_EQ(cloud.files.front().point_count, survey.finite_count);
  EXPECT_EQ(cloud.files.front().dropped_count, survey.dropped_count);
  return cloud;
}

/// Reads one file from bytes in memory with one reader.
inline PointCloud read_alone(Opener open, std::string_view text, AttributeSet wanted = AttributeSet::all()) {
  return read_alone(open, InputFile(std::as_bytes(std::span(text)), "memory"), wanted);
}

/// The message of the Error that reading throws; empty if it reads.
inline std::string reading_error(Opener open, std::string_view text) {
  try {
    read_alone(open, text);
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

/// Reads every prefix of a sample: each must give an Error or a cloud, never anything else. Answers how many
/// gave a cloud.
inline std::size_t count_readable_prefixes(Opener open, std::string_view sample) {
  std::size_t readable = 0;
  for (std::size_t length = 0; length < sample.size(); ++length) {
    // A copy of exactly this length, so that the address sanitizer sees every byte read beyond it.
    const std::string prefix(sample.substr(0, length));
    readable += reading_error(open, prefix).empty() ? 1 : 0;
  }
  return readable;
}

/// Appends the bytes of a value, little endian.
template <class Value>
void append(std::string& bytes, Value value) {
  char each[sizeof value];
  std::memcpy(each, &value, sizeof value);
  bytes.append(each, sizeof value);
}

/// Value of an extra dimension.
template <class Value>
Value extra_value(const PointCloud& cloud, std::string_view name, std::size_t point) {
  for (const ExtraDimension& dimension : cloud.extra_dimensions) {
    if (dimension.name != name) continue;
    EXPECT_EQ(dimension.byte_count, static_cast<int>(sizeof(Value)));
    EXPECT_EQ(dimension.values.size(), cloud.size() * sizeof(Value));
    Value value;
    std::memcpy(&value, dimension.values.data() + point * sizeof(Value), sizeof value);
    return value;
  }
  ADD_FAILURE() << "no extra dimension " << name;
  return {};
}

inline void expect_near(const glm::dvec3& found, const glm::dvec3& expected, double tolerance) {
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(found[axis], expected[axis], tolerance) << "axis " << axis;
}

}  // namespace alidade::test
