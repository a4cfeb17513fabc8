# ringsplat_room(NAME USES room... LIBRARIES target...)
#
# A room is one static library made of src/NAME/*.cpp with its public headers in
# include/ringsplat/NAME. USES lists the rooms it may include, which is also what it is
# linked with; tests/layering checks the include lines themselves.
add_library(ringsplat_flags INTERFACE)
add_library(ringsplat::flags ALIAS ringsplat_flags)
# No fused multiply-add behind our back: the image must have the same bits in every build.
target_compile_options(ringsplat_flags INTERFACE -ffp-contract=off)
# Simulated MPI loads the program once per rank; unique symbols would be shared between ranks.
target_compile_options(ringsplat_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-fno-gnu-unique>)
target_compile_features(ringsplat_flags INTERFACE cxx_std_20)

set(RINGSPLAT_WARNINGS -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
    $<$<BOOL:${RINGSPLAT_WARNINGS_AS_ERRORS}>:-Werror>)

function(ringsplat_room name)
  cmake_parse_arguments(ROOM "" "" "USES;LIBRARIES;PRIVATE_LIBRARIES" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${name}/*.cpp)
  add_library(ringsplat_${name} STATIC ${sources})
  add_library(ringsplat::${name} ALIAS ringsplat_${name})
  set_target_properties(ringsplat_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(ringsplat_${name}
    PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
    PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_compile_options(ringsplat_${name} PRIVATE ${RINGSPLAT_WARNINGS})
  list(TRANSFORM ROOM_USES PREPEND ringsplat_)
  target_link_libraries(ringsplat_${name}
    PUBLIC ringsplat_flags ${ROOM_USES} ${ROOM_LIBRARIES}
    PRIVATE ${ROOM_PRIVATE_LIBRARIES})
  set_property(GLOBAL APPEND PROPERTY RINGSPLAT_ROOMS ringsplat_${name})
endfunction()
