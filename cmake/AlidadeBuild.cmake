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

# Files are untrusted: what a mistake in reading them could be used for is made harder. Sanitizers do more of the same.
# Programs are position independent by the default of Debian's compilers.
if(NOT CMAKE_CXX_FLAGS MATCHES "-fsanitize")
  target_compile_options(alidade_flags INTERFACE -fstack-protector-strong)
  target_compile_definitions(alidade_flags INTERFACE $<$<CONFIG:Release,RelWithDebInfo,MinSizeRel>:_FORTIFY_SOURCE=2>)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    target_compile_options(alidade_flags INTERFACE -fcf-protection)
  endif()
  add_link_options(-Wl,-z,relro,-z,now)
endif()
# Without the libraries of which only headers are used, every start is shorter.
add_link_options(-Wl,--as-needed)
# The version that files, pictures and pages name.
target_compile_definitions(alidade_flags INTERFACE ALIDADE_VERSION="${PROJECT_VERSION}")

# alidade_library(NAME SOURCES...) declares the library alidade_NAME with its alias alidade::NAME, and has it installed.
# Whoever includes the headers compiles their formulas, so the rule on contraction holds for users of the library too.
function(alidade_library name)
  add_library(alidade_${name} STATIC ${ARGN})
  add_library(alidade::${name} ALIAS alidade_${name})
  set_target_properties(alidade_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  set_target_properties(alidade_${name} PROPERTIES UNITY_BUILD "${ALIDADE_UNITY}" UNITY_BUILD_BATCH_SIZE 6)
  target_compile_features(alidade_${name} PUBLIC cxx_std_20)
  target_compile_options(alidade_${name} PUBLIC -ffp-contract=off)
  target_include_directories(alidade_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/alidade>)
  target_link_libraries(alidade_${name} PRIVATE $<BUILD_INTERFACE:alidade_flags>)
  set_property(GLOBAL APPEND PROPERTY ALIDADE_LIBRARIES alidade_${name})
endfunction()

# alidade_compile_alone(FILES...), named from the root: left out of unity builds (ALIDADE_UNITY), in which several files of a
# library are compiled in one go. The clang build of ./dev nightly compiles every file alone, and so finds missing includes.
function(alidade_compile_alone)
  foreach(file IN LISTS ARGN)
    set_source_files_properties(${PROJECT_SOURCE_DIR}/${file} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endforeach()
endfunction()

# alidade_choose_lanes(TARGET) compiles a target that has lanes as ALIDADE_SCALAR says. Processors of before 2008 have SSSE3 and
# nothing wider; they take the scalar way.
function(alidade_choose_lanes target)
  target_compile_definitions(${target} PRIVATE HWY_DISABLED_TARGETS=HWY_SSSE3)
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

# alidade_room_tests(ROOM [SHARDS N] LIBRARIES libraries... SOURCES files...) declares the test program of a room, ROOM_test,
# which CTest runs as N processes, each with its share of the tests and a folder of its own for temporary files.
function(alidade_room_tests room)
  cmake_parse_arguments(TEST "" "SHARDS" "LIBRARIES;SOURCES" ${ARGN})
  if(NOT TEST_SHARDS)
    set(TEST_SHARDS 1)
  endif()
  set(program ${room}_test)
  add_executable(${program} ${TEST_SOURCES})
  target_link_libraries(${program} PRIVATE
    alidade_flags ${TEST_LIBRARIES} alidade_test_support fmt::fmt TBB::tbb GTest::gtest GTest::gtest_main)
  target_compile_definitions(${program} PRIVATE
    ALIDADE_SOURCE_FOLDER="${PROJECT_SOURCE_DIR}" ALIDADE_BUILD_FOLDER="${PROJECT_BINARY_DIR}"
    ALIDADE_SHARED_DATA="${PROJECT_SOURCE_DIR}/../shared/data")
  alidade_compile_quickly(${program})
  if(TARGET alidade_openimageio)
    # Found beside the program that loads it, also under the sanitizers, which keep the loader from seeing run paths.
    file(CREATE_LINK ${PROJECT_BINARY_DIR}/alidade_openimageio.so ${CMAKE_CURRENT_BINARY_DIR}/alidade_openimageio.so SYMBOLIC)
  endif()
  if(ALIDADE_PRECOMPILE)
    target_precompile_headers(${program} REUSE_FROM alidade_test_headers)
  endif()
  if(CMAKE_CXX_FLAGS MATCHES "-fsanitize=thread")
    target_sources(${program} PRIVATE ${PROJECT_SOURCE_DIR}/tests/support/thread_sanitizer_tbb.cpp)
  endif()
  math(EXPR last "${TEST_SHARDS} - 1")
  foreach(shard RANGE ${last})
    math(EXPR number "${shard} + 1")
    add_test(NAME ${room}_${number} COMMAND ${PROJECT_SOURCE_DIR}/tests/support/run_test.sh $<TARGET_FILE:${program}>)
    set_tests_properties(${room}_${number} PROPERTIES
      LABELS ${room} ENVIRONMENT "GTEST_TOTAL_SHARDS=${TEST_SHARDS};GTEST_SHARD_INDEX=${shard}")
  endforeach()
endfunction()
