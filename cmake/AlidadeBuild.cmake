# SPDX-License-Identifier: MIT
# Compile rules that hold for every target of the project.

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

# One target carries what every part of Alidade is compiled with. Contraction into fused multiply-add is off
# because answers must be the same bits on every machine; see octree/distance.h.
add_library(alidade_flags INTERFACE)
target_compile_features(alidade_flags INTERFACE cxx_std_20)
target_compile_options(alidade_flags INTERFACE -ffp-contract=off -Wall -Wextra -Wshadow -Wno-psabi)
target_include_directories(alidade_flags INTERFACE ${PROJECT_SOURCE_DIR})

# alidade_library(NAME SOURCES...) declares the library alidade_NAME with its alias alidade::NAME, and has it installed.
# Whoever includes the headers compiles their formulas, so the rule on contraction holds for users of the library too.
function(alidade_library name)
  add_library(alidade_${name} STATIC ${ARGN})
  add_library(alidade::${name} ALIAS alidade_${name})
  set_target_properties(alidade_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_compile_features(alidade_${name} PUBLIC cxx_std_20)
  target_compile_options(alidade_${name} PUBLIC -ffp-contract=off)
  target_include_directories(alidade_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/alidade>)
  target_link_libraries(alidade_${name} PRIVATE $<BUILD_INTERFACE:alidade_flags>)
  set_property(GLOBAL APPEND PROPERTY ALIDADE_LIBRARIES alidade_${name})
endfunction()

# alidade_compile_together(TARGET [files...]) has the sanitizers' builds (ALIDADE_COMPILE_TOGETHER) compile several files of
# a target in one go, which halves their time; all but these, whose helpers have names that others have too. The release
# build compiles every file alone, and so finds missing includes. Other targets are never compiled so: who links one file
# of a library would link its neighbours, and the program would load OpenImageIO and GDAL at every start.
function(alidade_compile_together target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD "${ALIDADE_COMPILE_TOGETHER}")
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# alidade_choose_lanes(TARGET) compiles a target that has lanes as ALIDADE_SCALAR says.
function(alidade_choose_lanes target)
  if(ALIDADE_SCALAR)
    # Highway's two ways to do without SIMD: its portable vectors where the compiler gets them right (gcc from 12.3
    # on, clang), otherwise one lane. Without the option it chooses likewise, so both are worth testing.
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 12.3)
      target_compile_definitions(${target} PRIVATE HWY_COMPILE_ONLY_SCALAR)
    else()
      target_compile_definitions(${target} PRIVATE HWY_COMPILE_ONLY_EMU128)
    endif()
  endif()
endfunction()

# alidade_compile_quickly(TARGET) is for code that nobody waits for when it runs, but everybody when it is compiled: tests
# and command lines, full of templates. It halves their compile time.
function(alidade_compile_quickly target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1> $<$<CONFIG:Debug>:-O0>)
endfunction()

# alidade_test(NAME LIBRARIES... SOURCES files...) declares one GoogleTest program, one CTest entry per test program.
function(alidade_test name)
  cmake_parse_arguments(TEST "" "" "LIBRARIES;SOURCES" ${ARGN})
  add_executable(${name} ${TEST_SOURCES})
  target_link_libraries(${name} PRIVATE alidade_flags ${TEST_LIBRARIES} GTest::gtest GTest::gtest_main)
  alidade_compile_quickly(${name})
  if(CMAKE_CXX_FLAGS MATCHES "-fsanitize=thread")
    target_sources(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/support/thread_sanitizer_tbb.cpp)
    target_link_libraries(${name} PRIVATE TBB::tbb)
  endif()
  add_test(NAME ${name} COMMAND ${name})
endfunction()
