// SPDX-License-Identifier: MIT
#include "cloud/laz/position_layer.h"

#include <algorithm>

namespace alidade {

/// How the layered LAZ codec groups points by return number r and number of returns n of their pulse.
struct ReturnsClass {
  std::uint8_t map;         ///< 0 to 5: neighbouring points of one group are spaced alike
  std::uint8_t level;       ///< |n - r|, at most 7
  std::uint8_t return_end;  ///< 2 * (r == 1) + (r >= n)
  std::uint8_t single;      ///< n == 1
};

/// By the byte of the record: r in bits 0-3, n in bits 4-7.
inline constexpr std::array<ReturnsClass, 256> k_returns_classes = [] {
  // By n, then r.
  constexpr std::uint8_t k_map[16][16] = {
      {0, 1, 2, 3, 4, 5, 3, 4, 4, 5, 5, 5, 5, 5, 5, 5}, {1, 0, 1, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3},
      {2, 1, 2, 4, 4, 4, 4, 4, 4, 4, 4, 3, 3, 3, 3, 3}, {3, 3, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4},
      {4, 3, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4}, {5, 3, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4},
      {3, 3, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4}, {4, 3, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4},
      {4, 3, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4}, {5, 3, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4},
      {5, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4}, {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 4, 4, 4},
      {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4, 4}, {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4},
      {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5}, {5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5},
  };
  std::array<ReturnsClass, 256> classes{};
  for (unsigned n = 0; n < 16; ++n)
    for (unsigned r = 0; r < 16; ++r)
      classes[16 * n + r] = {.map = k_map[n][r],
                             .level = static_cast<std::uint8_t>(std::min(n < r ? r - n : n - r, 7u)),
                             .return_end = static_cast<std::uint8_t>(2 * (r == 1) + (r >= n)),
                             .single = static_cast<std::uint8_t>(n == 1)};
  return classes;
}();

namespace {

enum ReturnChange : unsigned { k_same, k_next, k_previous, k_other };

unsigned return_change(unsigned last, unsigned now) {
  if (now == last) return k_same;
  if (now == ((last + 1) & 15)) return k_next;
  if (now == ((last - 1) & 15)) return k_previous;
  return k_other;
}

/// The LayeredPoint::Change bits of a record, against the last one of its channel.
unsigned changes_of(const std::byte* last, const std::byte* now) {
  using namespace point14;
  const unsigned last_returns = load<std::uint8_t>(last + k_returns);
  const unsigned returns = load<std::uint8_t>(now + k_returns);
  unsigned changes = return_change(last_returns & 15, returns & 15);
  if (last_returns >> 4 != returns >> 4) changes |= LayeredPoint::k_number_of_returns;
  if (load<std::uint16_t>(last + k_scan_angle) != load<std::uint16_t>(now + k_scan_angle))
    changes |= LayeredPoint::k_scan_angle;
  if (load<std::uint64_t>(last + k_gps_time) != load<std::uint64_t>(now + k_gps_time))
    changes |= LayeredPoint::k_gps_time;
  if (load<std::uint16_t>(last + k_point_source) != load<std::uint16_t>(now + k_point_source))
    changes |= LayeredPoint::k_point_source;
  return changes;
}

}  // namespace

void PositionLayer::Channel::open(const Last& value) {
  changes.reset();
  next_channel.reset();
  number_of_returns.reset();
  return_number.reset();
  return_step.reset();
  dx.reset();
  dy.reset();
  median_x.fill({});
  median_y.fill({});
  last = value;
  gps_time_changed = false;
}

void PositionLayer::start(const std::byte* first_record) {
  channels_.start(point14::channel(first_record),
                  Last{.x = load<std::int32_t>(first_record + point14::k_x),
                       .y = load<std::int32_t>(first_record + point14::k_y),
                       .returns = load<std::uint8_t>(first_record + point14::k_returns),
                       .record = first_record});
}

/// The returns byte of the next point of a channel.
template <class Coder>
[[gnu::always_inline]] inline unsigned PositionLayer::code_returns(Coder& coder, Channel& channel,
                                                                   unsigned changes, unsigned returns) {
  const unsigned last_return = channel.last.returns & 15u;
  unsigned number = channel.last.returns >> 4;
  if ((changes & LayeredPoint::k_number_of_returns) != 0)
    number = coder.symbol(channel.number_of_returns[number], returns >> 4);
  unsigned return_number = last_return;
  switch (changes & 3) {
    case k_same:
      break;
    case k_next:
      return_number = (last_return + 1) & 15;
      break;
    case k_previous:
      return_number = (last_return - 1) & 15;
      break;
    default:
      if ((changes & LayeredPoint::k_gps_time) != 0)
        return_number = coder.symbol(channel.return_number[last_return], returns & 15);
      else
        return_number =
            (last_return + 2 + coder.symbol(channel.return_step, (returns - last_return - 2) & 15)) & 15;
  }
  return number << 4 | return_number;
}

template <class Coder, class Byte>
[[gnu::always_inline]] inline void PositionLayer::code(Coder& coder, LayeredPoint& point, Byte* record) {
  Channel* channel = &channels_.current();
  unsigned number = 0;  // of the channel
  unsigned changes = 0;
  if constexpr (!Coder::k_decodes) {
    number = point14::channel(record);
    const Last& last = channels_.opened(number) ? channels_.of(number).last : channel->last;
    changes = changes_of(last.record, record);
    if (number != channels_.channel()) changes |= LayeredPoint::k_channel;
  }
  // Bit 0: first return, bit 1: last return, bit 2: new time.
  const unsigned last_end = k_returns_classes[channel->last.returns].return_end;
  const unsigned context = last_end >> 1 | (last_end & 1) << 1 | unsigned{channel->gps_time_changed} << 2;
  changes = coder.symbol(channel->changes[context], changes);
  if ((changes & LayeredPoint::k_channel) != 0) [[unlikely]] {
    const unsigned old = channels_.channel();
    const unsigned step = coder.symbol(channel->next_channel, (number - old - 1) & 3);
    channels_.change((old + step + 1) & 3);
    channel = &channels_.current();
  }

  Last& last = channel->last;
  const unsigned returns =
      (changes & 7) == 0 ? last.returns
                         : code_returns(coder, *channel, changes,
                                        coder.template value<std::uint8_t>(record + point14::k_returns));
  const ReturnsClass& group = k_returns_classes[returns];
  const unsigned time_changed = (changes & LayeredPoint::k_gps_time) != 0;
  const unsigned predictor = 2 * group.map + time_changed;

  MedianPredictor& median_x = channel->median_x[predictor];
  const std::int32_t new_x = coder.template value<std::int32_t>(record + point14::k_x);
  const std::int32_t dx =
      coder.integer(channel->dx, median_x.median(), wrapped_difference(new_x, last.x), group.single);
  median_x.insert(dx);
  last.x = wrapped_sum(last.x, dx);
  const int x_bits = channel->dx.last_k();

  MedianPredictor& median_y = channel->median_y[predictor];
  const std::int32_t new_y = coder.template value<std::int32_t>(record + point14::k_y);
  const std::int32_t dy = coder.integer(channel->dy, median_y.median(), wrapped_difference(new_y, last.y),
                                        group.single + bits_context(x_bits, 20));
  median_y.insert(dy);
  last.y = wrapped_sum(last.y, dy);

  last.returns = static_cast<std::uint8_t>(returns);
  channel->gps_time_changed = time_changed != 0;
  const unsigned coded_channel = channels_.channel();
  if constexpr (Coder::k_decodes) {
    store(record + point14::k_x, last.x);
    store(record + point14::k_y, last.y);
    store(record + point14::k_returns, last.returns);
    point14::put_channel(record, coded_channel);
  } else {
    last.record = record;
  }
  point = {.channel = static_cast<std::uint8_t>(coded_channel),
           .changes = static_cast<std::uint8_t>(changes),
           .z_context = static_cast<std::uint8_t>(group.single +
                                                  bits_context((x_bits + channel->dy.last_k()) / 2, 18)),
           .level = group.level,
           .return_end = group.return_end};
}

void PositionLayer::decode(ArithmeticDecoder& decoder, std::span<LayeredPoint> points, std::byte* records,
                           std::size_t record_size) {
  // A copy that nothing else points to stays in registers, if all that uses it is inlined.
  ArithmeticDecoder local = decoder;
  for (LayeredPoint& point : points) {
    code(local, point, records);
    records += record_size;
  }
  decoder = local;
}

void PositionLayer::encode(ArithmeticEncoder& encoder, std::span<LayeredPoint> points,
                           const std::byte* records, std::size_t record_size) {
  for (LayeredPoint& point : points) {
    code(encoder, point, records);
    records += record_size;
  }
}

}  // namespace alidade
