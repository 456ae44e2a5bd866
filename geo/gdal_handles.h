// SPDX-License-Identifier: MIT
#pragma once

#include <cpl_error.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <gdal.h>

#include <cstddef>
#include <memory>
#include <span>
#include <string>

// What belongs to GDAL, given back when it is no longer used.

namespace alidade {

/// GDAL says nothing by itself while this lives; what it would have said last is kept.
class QuietGdal {
 public:
  QuietGdal() {
    CPLPushErrorHandler(CPLQuietErrorHandler);
    CPLErrorReset();
  }
  ~QuietGdal() { CPLPopErrorHandler(); }
  QuietGdal(const QuietGdal&) = delete;
  QuietGdal& operator=(const QuietGdal&) = delete;
};

/// A TIFF file in memory under a name of its own that is gone with this object.
class GdalMemoryFile {
 public:
  GdalMemoryFile() : name_(fmt::format("/vsimem/alidade_{}.tif", static_cast<const void*>(this))) {}
  ~GdalMemoryFile() { VSIUnlink(name_.c_str()); }
  GdalMemoryFile(const GdalMemoryFile&) = delete;
  GdalMemoryFile& operator=(const GdalMemoryFile&) = delete;

  const char* name() const { return name_.c_str(); }
  std::span<const std::byte> bytes() const {
    vsi_l_offset size = 0;
    const GByte* const data = VSIGetMemFileBuffer(name_.c_str(), &size, FALSE);
    if (data == nullptr) return {};
    return std::as_bytes(std::span(data, static_cast<std::size_t>(size)));
  }

 private:
  std::string name_;
};

struct CloseGdalDataset {
  void operator()(void* dataset) const { GDALClose(dataset); }
};
using GdalDataset = std::unique_ptr<void, CloseGdalDataset>;

}  // namespace alidade
