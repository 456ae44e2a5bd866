// SPDX-License-Identifier: MIT
// Channels of the points of a chunk, and which models and which last values an item of them uses.
#include "cloud/laz/layer.h"

#include <gtest/gtest.h>

#include <vector>

namespace alidade {
namespace {

struct CountingModels {
  int resets = 0;
  int uses = 0;
  void reset() {
    ++resets;
    uses = 0;
  }
};

struct Use {
  int models_uses;  // how often the models of the point have been used since they were fresh
  int predicted_from;
  bool operator==(const Use&) const = default;
};

/// The value of point i is i.
std::vector<Use> uses_of(int version, const std::vector<std::uint8_t>& channels) {
  ItemChannels<CountingModels, int> item(version);
  item.start(channels[0], 0);
  std::vector<Use> uses;
  for (std::size_t i = 1; i < channels.size(); ++i) {
    LayeredPoint point{};
    point.channel = channels[i];
    if (channels[i] != channels[i - 1]) point.changes = LayeredPoint::k_channel;
    item.select(point);
    uses.push_back({item.models().uses++, item.last_value()});
    item.last_value() = static_cast<int>(i);
  }
  return uses;
}

TEST(ItemChannels,
     version_3_takes_points_that_keep_their_channel_for_channel_0_and_predicts_from_the_one_before) {
  // Points 1 to 5 use models of channel 1 (new), 0, 0, 2 (new), 0; the value of point 2 goes to the slot of
  // channel 1, so that point 3 is predicted from point 0.
  EXPECT_EQ(uses_of(3, {0, 1, 1, 0, 2, 2}), (std::vector<Use>{{0, 0}, {0, 1}, {1, 0}, {0, 3}, {2, 4}}));
}

TEST(ItemChannels, version_4_predicts_from_the_last_point_of_the_channel) {
  EXPECT_EQ(uses_of(4, {0, 1, 1, 0, 2, 2}), (std::vector<Use>{{0, 0}, {1, 1}, {0, 0}, {0, 3}, {1, 4}}));
}

TEST(ItemChannels, with_channel_0_alone_the_versions_agree) {
  EXPECT_EQ(uses_of(3, {0, 0, 0, 0}), uses_of(4, {0, 0, 0, 0}));
  EXPECT_EQ(uses_of(2, {0, 1, 1, 0, 2, 2}), uses_of(3, {0, 1, 1, 0, 2, 2}));
}

TEST(ItemChannels, a_channel_other_than_0_opens_channel_0_with_its_own_value_in_version_3) {
  EXPECT_EQ(uses_of(3, {2, 2, 2}), (std::vector<Use>{{0, 0}, {1, 1}}));
}

TEST(ItemChannels, a_new_chunk_begins_with_fresh_models) {
  ItemChannels<CountingModels, int> item(4);
  item.start(1, 7);
  item.models().uses = 5;
  item.start(1, 8);
  LayeredPoint point{};
  point.channel = 1;
  item.select(point);
  EXPECT_EQ(item.models().uses, 0);
  EXPECT_EQ(item.last_value(), 8);
}

}  // namespace
}  // namespace alidade
