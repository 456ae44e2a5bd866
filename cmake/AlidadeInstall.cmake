# SPDX-License-Identifier: MIT
# What `cmake --install` puts where: libraries, headers under the names they are included by, and the package files.

get_property(ALIDADE_LIBRARIES GLOBAL PROPERTY ALIDADE_LIBRARIES)
install(TARGETS ${ALIDADE_LIBRARIES} EXPORT AlidadeTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT AlidadeTargets NAMESPACE alidade:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/Alidade)

set(ALIDADE_HEADER_FOLDERS base cloud octree mesh simulation)
if(ALIDADE_BUILD_RENDERER)
  list(APPEND ALIDADE_HEADER_FOLDERS geo image camera renderer visibility compare)
endif()
if(ALIDADE_BUILD_DATABASE)
  list(APPEND ALIDADE_HEADER_FOLDERS database)
endif()
install(DIRECTORY ${ALIDADE_HEADER_FOLDERS} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/alidade
        FILES_MATCHING PATTERN "*.h")

include(CMakePackageConfigHelpers)
configure_package_config_file(
  ${CMAKE_CURRENT_LIST_DIR}/AlidadeConfig.cmake.in ${PROJECT_BINARY_DIR}/AlidadeConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/Alidade)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/AlidadeConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/AlidadeConfig.cmake ${PROJECT_BINARY_DIR}/AlidadeConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/Alidade)
