// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "base/input_file.h"
#include "renderer/picture_identity.h"

namespace alidade {

/// The head of a checkpoint, field by field; renderer/checkpoint.h has its bytes.
struct CheckpointHead {
  std::uint64_t file_bytes = 0;
  std::uint64_t rest_checksum = 0;
  std::uint32_t width = 0, height = 0;
  bool with_noise = false;
  std::uint32_t pass_end = 0;
  std::uint64_t samples_taken = 0;
  double seconds = 0.0;
  std::uint32_t samples = 0;  ///< per pixel, in the end
  PictureIdentity identity;
  std::uint64_t head_bytes = 0;  ///< where the rest begins
};

/// Bytes of the head, its checksum included; sets head_bytes.
std::vector<std::byte> encode_checkpoint_head(CheckpointHead& head);

/// Whether the magic is there.
bool begins_as_checkpoint(InputFile& file);

/// Errors: not a checkpoint; another byte order or version; cut short or too long; damaged.
CheckpointHead read_checkpoint_head(InputFile& file);

}  // namespace alidade
