# SPDX-License-Identifier: MIT
# What `cmake --install` puts where: libraries, headers under the names they are included by, and the package files.

get_property(ALIDADE_LIBRARIES GLOBAL PROPERTY ALIDADE_LIBRARIES)
install(TARGETS ${ALIDADE_LIBRARIES} EXPORT AlidadeTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT AlidadeTargets NAMESPACE alidade:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/Alidade)

# Only the public headers, of the rooms that are built.
set(ALIDADE_PUBLIC_HEADERS_LIST ${CMAKE_CURRENT_LIST_DIR}/public_headers.txt)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${ALIDADE_PUBLIC_HEADERS_LIST})
file(STRINGS ${ALIDADE_PUBLIC_HEADERS_LIST} ALIDADE_PUBLIC_HEADERS REGEX "^[a-z0-9_/]+\\.h \\|")
foreach(LINE IN LISTS ALIDADE_PUBLIC_HEADERS)
  string(REGEX REPLACE " .*" "" HEADER "${LINE}")
  string(REGEX REPLACE "^extensions/" "extension_" ROOM "${HEADER}")
  string(REGEX REPLACE "/.*" "" ROOM "${ROOM}")
  if(TARGET alidade_${ROOM})
    cmake_path(GET HEADER PARENT_PATH FOLDER)
    install(FILES ${HEADER} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/alidade/${FOLDER})
  endif()
endforeach()

include(CMakePackageConfigHelpers)
configure_package_config_file(
  ${CMAKE_CURRENT_LIST_DIR}/AlidadeConfig.cmake.in ${PROJECT_BINARY_DIR}/AlidadeConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/Alidade)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/AlidadeConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/AlidadeConfig.cmake ${PROJECT_BINARY_DIR}/AlidadeConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/Alidade)
