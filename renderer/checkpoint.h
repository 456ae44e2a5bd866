// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>

#include "base/fingerprint.h"
#include "base/input_file.h"
#include "renderer/image_state.h"
#include "renderer/render.h"

// Checkpoints: an image under way in a file, so that a render which was interrupted or killed resumes and
// gives the same bytes. Little endian.
//
//   byte 0   8 B  "ALIDPART"             magic
//        8   4 B  0x01020304             byte order
//       12   4 B  1                      version of this format
//       16   8 B                         bytes of the file
//       24   8 B                         checksum of the head: of bytes 0 to `head`, this field taken as 0
//       32   8 B                         checksum of the rest: of the checksums of its blocks of 1 MiB
//       40   4 B, 4 B                    width, height, pixels
//       48   4 B                         1 if the sums for noise are kept, else 0
//       52   4 B                         samples that tiles are on their way to
//       56   8 B                         camera samples taken
//       64   8 B  double                 seconds spent
//       72   4 B                         bytes of the fingerprint, which follows; both together are the head
//       76   4 B                         camera samples for the whole, per pixel
//       80        fingerprint               per entry: 4 B length of name, 4 B length of value, name, value
//     head        tiles                  16 B each: samples, 1 if stopped, rays (8 B)
//                 with noise: per tile   24 doubles, LevelSums
//                 per row of tiles       means (3 doubles), counts of met surfaces (4 B) and with noise
//                                        squares and earlier means (3 floats each), pixel by pixel
//                 finished part: per row of tiles, its layers of the pixels' centres, pixel by pixel
//
// A checkpoint of a part has only the tiles and pixels of the part, in the same order. A finished part is
// such a checkpoint with all samples, 0 seconds and the layers of the pixels' centres; its fingerprint ends
// with the image_entries() (renderer/merge_parts.h).

namespace alidade::renderer {

/// Writes the state; the file is written completely or not at all, an earlier one stays until then. No
/// thread may change the state meanwhile. Memory: 2 MiB. Errors: those of OutputFile, above all a full disk.
void write_checkpoint(const std::filesystem::path& file, const Fingerprint& fingerprint, int samples,
                      const ImageState& state, double seconds);

/// Reads a state back. `state` must have been made for the image that is requested; it is only of use if
/// nothing is thrown. `samples` is the requested number per pixel. Errors: not a checkpoint; another byte
/// order, version or image, naming the first thing that differs; a file cut short, too long or damaged.
/// Memory: the fingerprint, at most the file's size, and 1 MiB.
void read_checkpoint(InputFile file, const Fingerprint& fingerprint, int samples, ImageState& state);

/// Writes a finished part; `film` has the layers of the pixels' centres that are requested. Errors: those of
/// OutputFile.
void write_part(const std::filesystem::path& file, const Fingerprint& fingerprint, int samples,
                const ImageState& state, const image::Film& film, bool overwrite);

/// The head of a file of a part.
struct PartHead {
  std::string file;
  ImagePart part;
  int width = 0, height = 0;  ///< of the image, pixels
  int samples = 0;            ///< per pixel, in the end
  bool with_noise = false;
  std::uint64_t samples_taken = 0;  ///< camera samples
  std::uint64_t file_bytes = 0, head_bytes = 0;
  std::uint64_t rest_checksum = 0;  ///< of all behind the head
  Fingerprint fingerprint{};        ///< "part" left out
};

/// Reads the head alone. Errors: no checkpoint of an image; another byte order or version; damaged; cut
/// short or too long; sizes that no image has.
PartHead read_part_head(const std::filesystem::path& file);

/// Reads a finished part into the state and the film of the whole image, which have its size and layers.
/// Errors: unfinished; damaged.
void read_part(const PartHead& head, ImageState& state, image::Film& film);

/// Whether a file begins as checkpoints do, of whatever version. Errors: those of InputFile.
bool is_checkpoint(const std::filesystem::path& file);

/// The progress that a checkpoint records.
struct CheckpointSummary {
  std::string image;                ///< CheckpointOptions::image
  std::uint64_t samples_taken = 0;  ///< camera samples
  double share = 0.0;               ///< of all camera samples, 0 to 1
  double seconds = 0.0;             ///< spent
};

/// Reads the head alone. Errors: as read_checkpoint().
CheckpointSummary read_checkpoint_summary(const std::filesystem::path& file);

}  // namespace alidade::renderer
