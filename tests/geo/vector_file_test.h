// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>
#include <ogrsf_frmts.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "base/error.h"
#include "cloud/crs.h"
#include "geo/gdal_reference.h"

namespace alidade::test {

using namespace geo;

inline GdalReference reference_of(int epsg) {
  GdalReference reference(OSRNewSpatialReference(nullptr));
  EXPECT_EQ(OSRImportFromEPSG(reference.get(), epsg), OGRERR_NONE);
  return reference;
}

/// UTM zone 32 north.
inline Crs utm() {
  char* text = nullptr;
  OSRExportToWkt(reference_of(25832).get(), &text);
  Crs crs;
  crs.wkt = text;
  CPLFree(text);
  return crs;
}

/// A test with an empty folder of its own for vector files.
class VectorFileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const ::testing::TestInfo* const info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              fmt::format("alidade_{}_{}", info->test_suite_name(), info->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  /// A new file of that driver with one layer, which `fill` puts features into; `epsg` 0: no reference
  /// system.
  std::filesystem::path write_layer(const std::string& name, const char* driver, int epsg,
                                    OGRwkbGeometryType type,
                                    const std::function<void(OGRLayerH layer)>& fill) const {
    RegisterOGRGeoPackage();
    RegisterOGRShape();
    const std::filesystem::path path = folder_ / name;
    const GdalDataset dataset(
        GDALCreate(GDALGetDriverByName(driver), path.c_str(), 0, 0, 0, GDT_Unknown, nullptr));
    const GdalReference reference = epsg != 0 ? reference_of(epsg) : nullptr;
    fill(GDALDatasetCreateLayer(dataset.get(), "things", reference.get(), type, nullptr));
    return path;
  }

  /// The message of the Error that `task` throws; empty if it throws none.
  template <class Task>
  static std::string problem_in(const Task& task) {
    try {
      task();
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path folder_;
};

}  // namespace alidade::test
