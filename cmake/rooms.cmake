# A room is a folder: one static library, one include prefix, one namespace, one row
#
#   room(NAME MAY_INCLUDE other rooms ... LIBS third-party targets ...)
#
# in its house's CMakeLists.txt. scripts/check_rooms reads the same rows and fails on an #include they do not allow.
# Files named *_test.cpp in the room become the test program HOUSE_NAME_test; the file main.cpp, if any, is left to
# an explicit add_executable.

get_filename_component(ASSAY_SOURCE_DIR "${CMAKE_CURRENT_LIST_DIR}/.." ABSOLUTE)

add_library(assay_flags INTERFACE)
target_compile_options(assay_flags INTERFACE
  -Wall -Wextra -Wconversion -Wno-sign-conversion -ffp-contract=off $<$<BOOL:${ASSAY_WERROR}>:-Werror>)
if(ASSAY_SANITIZE)
  target_compile_options(assay_flags INTERFACE -fsanitize=${ASSAY_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer -g)
  target_link_options(assay_flags INTERFACE -fsanitize=${ASSAY_SANITIZE})
endif()

function(room name)
  cmake_parse_arguments(room "" "" "MAY_INCLUDE;LIBS" ${ARGN})
  get_filename_component(house "${CMAKE_CURRENT_SOURCE_DIR}" NAME)
  file(GLOB sources CONFIGURE_DEPENDS ${name}/*.cpp)
  set(tests ${sources})
  list(FILTER tests INCLUDE REGEX "_test\\.cpp$")
  list(FILTER sources EXCLUDE REGEX "(_test|main)\\.cpp$")
  set(target ${house}_${name})
  list(TRANSFORM room_MAY_INCLUDE PREPEND ${house}_)
  if(sources)
    add_library(${target} STATIC ${sources})
    target_include_directories(${target} PUBLIC ${CMAKE_CURRENT_SOURCE_DIR})
    target_link_libraries(${target} PUBLIC ${room_MAY_INCLUDE} ${room_LIBS} PRIVATE assay_flags)
  else()
    add_library(${target} INTERFACE)
    target_include_directories(${target} INTERFACE ${CMAKE_CURRENT_SOURCE_DIR})
    target_link_libraries(${target} INTERFACE ${room_MAY_INCLUDE} ${room_LIBS})
  endif()
  if(tests)
    add_executable(${target}_test ${tests})
    target_link_libraries(${target}_test PRIVATE ${target} assay_flags GTest::gtest_main)
    # Tests find the data beside them, and the programs they start, through these two.
    target_compile_definitions(${target}_test PRIVATE
      ASSAY_SOURCE_DIR="${ASSAY_SOURCE_DIR}" ASSAY_BINARY_DIR="${CMAKE_BINARY_DIR}")
    gtest_discover_tests(${target}_test TEST_PREFIX "${house}/${name}: " DISCOVERY_MODE PRE_TEST
      PROPERTIES LABELS "${house};${name}" TIMEOUT 600)
  endif()
endfunction()
include(GoogleTest)
