// SPDX-License-Identifier: MIT
#pragma once

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_http.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <cpl_vsi_error.h>
#include <gdal.h>
#include <gdal_frmts.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>
#include <ogrsf_frmts.h>
#include <atomic>

#include "geo/gdal_library.h"

// The functions of GDAL under their own names, which in this namespace hide those that its headers declare:
// objects that are called like them, and find the function in the library at the first call. What is not in
// the list below is not found when a program is linked.

namespace alidade::geo {

template <class Result, class... Arguments>
class GdalFunction {
 public:
  using Pointer = Result (*)(Arguments...);

  explicit constexpr GdalFunction(const char* name) : name_(name) {}

  Result operator()(Arguments... arguments) const { return Pointer(*this)(arguments...); }
  /// Errors: those of gdal_function().
  operator Pointer() const {
    Pointer found = found_;
    if (found == nullptr) found_ = found = reinterpret_cast<Pointer>(gdal_function(name_));
    return found;
  }

 private:
  const char* name_;
  mutable std::atomic<Pointer> found_ = nullptr;
};

/// Has the type that a function needs; never called.
template <class Result, class... Arguments>
GdalFunction<Result, Arguments...> like(Result (*function)(Arguments...));

// clang-format off
#define ALIDADE_GDAL_FUNCTIONS(X) \
  X(CPLErrorReset) X(CPLGetLastErrorMsg) X(CPLGetLastErrorType) X(CPLPopErrorHandler) \
  X(CPLPushErrorHandler) X(CPLQuietErrorHandler) X(CPLAtof) X(CPLGetConfigOption) \
  X(CPLGetThreadLocalConfigOption) X(CPLSetConfigOption) X(CPLSetThreadLocalConfigOption) \
  X(CPLHTTPDestroyResult) X(CPLHTTPFetchEx) X(CPLParseNameValue) X(CSLDestroy) X(CSLTokenizeString2) \
  X(VSICurlPartialClearCache) X(VSIErrorReset) X(VSIFCloseL) X(VSIFOpenExL) X(VSIFOpenL) X(VSIFReadL) \
  X(VSIFSeekL) X(VSIFTellL) X(VSIFWriteL) X(VSIFileFromMemBuffer) X(VSIFree) X(VSIGetLastErrorMsg) \
  X(VSIGetLastErrorNo) X(VSIGetMemFileBuffer) X(VSINetworkStatsGetAsSerializedJSON) X(VSIStatExL) \
  X(VSIUnlink) \
  X(GDALAllRegister) X(GDALRegister_COG) X(GDALRegister_GTiff) X(GDALRegister_MEM) X(RegisterOGRGeoJSON) \
  X(RegisterOGRGeoPackage) X(RegisterOGRShape) X(GDALVersionInfo) X(GDALAddBand) X(GDALClose) \
  X(GDALCreate) X(GDALCreateCopy) X(GDALDataTypeIsComplex) X(GDALDatasetCommitTransaction) \
  X(GDALDatasetCreateLayer) X(GDALDatasetGetLayer) X(GDALDatasetGetLayerCount) X(GDALDatasetRasterIO) \
  X(GDALDatasetStartTransaction) X(GDALFlushCache) X(GDALGetDatasetDriver) X(GDALGetDriverByName) \
  X(GDALGetDriverShortName) X(GDALGetGeoTransform) X(GDALGetMaskBand) X(GDALGetProjectionRef) \
  X(GDALGetRasterBand) X(GDALGetRasterCount) X(GDALGetRasterDataType) X(GDALGetRasterOffset) \
  X(GDALGetRasterScale) X(GDALGetRasterUnitType) X(GDALGetRasterXSize) X(GDALGetRasterYSize) X(GDALOpen) \
  X(GDALOpenEx) X(GDALRasterIO) X(GDALSetDescription) X(GDALSetGeoTransform) X(GDALSetMetadataItem) \
  X(GDALSetProjection) X(GDALSetRasterColorInterpretation) X(GDALSetRasterNoDataValue) \
  X(GDALSetRasterUnitType) \
  X(OGR_F_Create) X(OGR_F_Destroy) X(OGR_F_GetFID) X(OGR_F_GetFieldAsDouble) X(OGR_F_GetFieldAsString) \
  X(OGR_F_GetFieldDefnRef) X(OGR_F_GetFieldIndex) X(OGR_F_GetGeometryRef) X(OGR_F_IsFieldSetAndNotNull) \
  X(OGR_F_SetFieldDouble) X(OGR_F_SetFieldInteger64) X(OGR_F_SetFieldNull) X(OGR_F_SetFieldString) \
  X(OGR_F_SetGeometryDirectly) X(OGR_Fld_Create) X(OGR_Fld_Destroy) X(OGR_Fld_GetType) \
  X(OGR_L_CreateFeature) X(OGR_L_CreateField) X(OGR_L_GetLayerDefn) X(OGR_L_GetName) \
  X(OGR_L_GetNextFeature) X(OGR_L_GetSpatialRef) X(OGR_L_ResetReading) \
  X(OGRGeometryTypeToName) X(OGR_GT_Flatten) X(OGR_G_AddGeometryDirectly) X(OGR_G_AddPoint) \
  X(OGR_G_AddPoint_2D) X(OGR_G_CloseRings) X(OGR_G_CreateGeometry) X(OGR_G_DestroyGeometry) \
  X(OGR_G_GetGeometryCount) X(OGR_G_GetGeometryRef) X(OGR_G_GetGeometryType) X(OGR_G_GetLinearGeometry) \
  X(OGR_G_GetPointCount) X(OGR_G_GetX) X(OGR_G_GetY) X(OGR_G_GetZ) X(OGR_G_Is3D) X(OGR_G_IsEmpty) \
  X(OSRClone) X(OSRExportToPROJJSON) X(OSRExportToWktEx) X(OSRGetAttrValue) X(OSRGetAuthorityCode) \
  X(OSRGetAxesCount) X(OSRGetAxis) X(OSRGetLinearUnits) X(OSRGetName) \
  X(OSRImportFromEPSG) X(OSRImportFromWkt) X(OSRIsGeocentric) X(OSRIsLocal) X(OSRIsProjected) \
  X(OSRIsSame) X(OSRIsSameEx) X(OSRNewSpatialReference) X(OSRRelease) X(OSRSetAxisMappingStrategy) \
  X(OSRSetCompoundCS) X(OSRSetFromUserInput) X(OSRSetLocalCS) X(OSRStripVertical) X(OCTClone) \
  X(OCTDestroyCoordinateTransformation) X(OCTNewCoordinateTransformation) X(OCTTransform) \
  X(OCTTransformEx)
// clang-format on
#define ALIDADE_GDAL_FUNCTION(name) inline constinit const decltype(like(&::name)) name{#name};
ALIDADE_GDAL_FUNCTIONS(ALIDADE_GDAL_FUNCTION)
#undef ALIDADE_GDAL_FUNCTION
#undef ALIDADE_GDAL_FUNCTIONS

}  // namespace alidade::geo
