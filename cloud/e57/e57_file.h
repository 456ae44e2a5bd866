// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "cloud/e57/e57_document.h"
#include "cloud/e57/e57_pages.h"

namespace alidade {

/// An E57 file whose XML is understood and checked against the file: every section and every image lies
/// inside it, sections of scans do not overlap, and no scan claims more records than its section could hold.
class E57File {
 public:
  /// Errors: those of E57Pages; XML that is damaged, has a document type, is larger than 64 MiB or has more
  /// than 8 million elements and attributes; what docs/e57.md lists as refused. They name page, scan, field
  /// or image. Memory: a constant factor of the XML's size.
  explicit E57File(InputFile file);

  const E57Document& document() const { return document_; }
  E57Pages& pages() { return pages_; }
  const E57Pages& pages() const { return pages_; }

  /// Gives the bytes of a file inside the file to `take`, piece by piece. Errors: a damaged page.
  void read_blob(const E57Blob& blob, const std::function<void(std::span<const std::byte>)>& take) {
    pages_.visit(blob.place, blob.length, take);
  }

 private:
  E57Pages pages_;
  E57Document document_;
};

}  // namespace alidade
