# SPDX-License-Identifier: MIT
# Extensions: folders below extensions/, each with all of a feature that the core can do without. docs/architecture.md,
# "Extensions", lists what such a folder contains.

# The value "all" stands for all folders, so that removing a folder removes its extension.
set(ALIDADE_EXTENSIONS all CACHE STRING "Extensions to build: a list of folders below extensions/, or all")
file(GLOB folders RELATIVE ${PROJECT_SOURCE_DIR}/extensions CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/extensions/*/CMakeLists.txt)
list(TRANSFORM folders REPLACE "/CMakeLists.txt" "" OUTPUT_VARIABLE ALIDADE_ALL_EXTENSIONS)
if(ALIDADE_EXTENSIONS STREQUAL "all")
  set(ALIDADE_BUILT_EXTENSIONS ${ALIDADE_ALL_EXTENSIONS})
else()
  set(ALIDADE_BUILT_EXTENSIONS ${ALIDADE_EXTENSIONS})
  list(REMOVE_DUPLICATES ALIDADE_BUILT_EXTENSIONS)
endif()
foreach(name IN LISTS ALIDADE_BUILT_EXTENSIONS)
  if(NOT name IN_LIST ALIDADE_ALL_EXTENSIONS)
    list(JOIN ALIDADE_ALL_EXTENSIONS ", " known)
    message(FATAL_ERROR "ALIDADE_EXTENSIONS: unknown extension '${name}'; expected all, or a list of: ${known}")
  endif()
endforeach()

# alidade_extension(NAME SOURCES files... [LIBRARIES libraries...] [MANUALS files...]) declares the library
# alidade_extension_NAME, of all sources but command.cpp and python.cpp, which alidade_add_extensions() compiles, and adds manuals
# of commands: GROUP_COMMAND.txt, or COMMAND.txt for one of no group.
function(alidade_extension name)
  cmake_parse_arguments(EXTENSION "" "" "SOURCES;LIBRARIES;MANUALS" ${ARGN})
  list(TRANSFORM EXTENSION_MANUALS PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  set_property(GLOBAL APPEND PROPERTY ALIDADE_EXTENSION_MANUALS ${EXTENSION_MANUALS})
  alidade_library(extension_${name} ${EXTENSION_SOURCES})
  target_link_libraries(alidade_extension_${name} PUBLIC ${EXTENSION_LIBRARIES} PRIVATE fmt::fmt TBB::tbb)
endfunction()

# alidade_extension_files(FILE VARIABLE): the files of this name in the folders of the extensions that are built.
function(alidade_extension_files file variable)
  set(files "")
  foreach(name IN LISTS ALIDADE_BUILT_EXTENSIONS)
    if(EXISTS ${PROJECT_SOURCE_DIR}/extensions/${name}/${file})
      list(APPEND files ${PROJECT_SOURCE_DIR}/extensions/${name}/${file})
    endif()
  endforeach()
  set(${variable} ${files} PARENT_SCOPE)
endfunction()

# alidade_add_extensions(TARGET FILE HEADER NAMESPACE HOOKS): compiles the FILE of each extension that has one into a target, and a source
# that defines NAMESPACE::add_extensions(HOOKS&), which the header declares. It calls extensions::set_up_NAME() of each extension
# with a hooks.cpp, and extensions::add_NAME(HOOKS&) of each with that FILE.
function(alidade_add_extensions target file header door hooks)
  set(declarations "")
  set(calls "")
  foreach(name IN LISTS ALIDADE_BUILT_EXTENSIONS)
    set(folder ${PROJECT_SOURCE_DIR}/extensions/${name})
    if(EXISTS ${folder}/hooks.cpp)
      string(APPEND declarations "void set_up_${name}();\n")
      string(APPEND calls "  extensions::set_up_${name}();\n")
    endif()
    if(EXISTS ${folder}/${file})
      target_sources(${target} PRIVATE ${folder}/${file})
      string(APPEND declarations "void add_${name}(${door}::${hooks}& hooks);\n")
      string(APPEND calls "  extensions::add_${name}(hooks);\n")
    endif()
    if(TARGET alidade_extension_${name})
      target_link_libraries(${target} PRIVATE alidade_extension_${name})
    endif()
  endforeach()
  configure_file(${PROJECT_SOURCE_DIR}/cmake/extensions.cpp.in ${CMAKE_CURRENT_BINARY_DIR}/extensions.cpp @ONLY)
  target_sources(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR}/extensions.cpp)
endfunction()
