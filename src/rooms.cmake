# ringsplat_room(NAME FOLDERS folder... USES room... LIBRARIES target... PRIVATE_LIBRARIES target...)
#
# A room is one static library made of src/NAME/*.cpp and src/NAME/FOLDER/*.cpp for the FOLDERS given, with its public
# headers in include/ringsplat/NAME. USES lists the rooms it may include, which is also what it is
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

# What most files include, compiled once.
set(RINGSPLAT_COMMON_HEADERS <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <map> <memory> <optional> <span>
    <string> <vector> <fmt/format.h> <glm/glm.hpp>)
file(CONFIGURE OUTPUT headers.cpp CONTENT "")
add_library(ringsplat_headers OBJECT ${CMAKE_CURRENT_BINARY_DIR}/headers.cpp)
target_precompile_headers(ringsplat_headers PRIVATE ${RINGSPLAT_COMMON_HEADERS})
target_link_libraries(ringsplat_headers PRIVATE ringsplat_flags fmt::fmt glm::glm)
target_compile_options(ringsplat_headers PRIVATE ${RINGSPLAT_WARNINGS})

function(ringsplat_room name)
  cmake_parse_arguments(ROOM "" "" "FOLDERS;USES;LIBRARIES;PRIVATE_LIBRARIES" ${ARGN})
  set(patterns ${PROJECT_SOURCE_DIR}/src/${name}/*.cpp)
  foreach(folder IN LISTS ROOM_FOLDERS)
    list(APPEND patterns ${PROJECT_SOURCE_DIR}/src/${name}/${folder}/*.cpp)
  endforeach()
  file(GLOB sources CONFIGURE_DEPENDS ${patterns})
  add_library(ringsplat_${name} STATIC ${sources})
  add_library(ringsplat::${name} ALIAS ringsplat_${name})
  set_target_properties(ringsplat_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(ringsplat_${name}
    PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
    PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_compile_options(ringsplat_${name} PRIVATE ${RINGSPLAT_WARNINGS})
  target_precompile_headers(ringsplat_${name} REUSE_FROM ringsplat_headers)
  list(TRANSFORM ROOM_USES PREPEND ringsplat_)
  target_link_libraries(ringsplat_${name}
    PUBLIC ringsplat_flags ${ROOM_USES} ${ROOM_LIBRARIES}
    PRIVATE ${ROOM_PRIVATE_LIBRARIES})
  set_property(GLOBAL APPEND PROPERTY RINGSPLAT_ROOMS ringsplat_${name})
endfunction()

# ringsplat_run_path(TARGET folder...): the folders where an installed program or library looks for others, besides those
# that it was linked in. They are the same in the build tree: a run path that installing rewrites is filled up with ':',
# and the loader takes what is between two of them for the current folder.
function(ringsplat_run_path target)
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "${ARGN}" INSTALL_RPATH_USE_LINK_PATH ON BUILD_WITH_INSTALL_RPATH ON)
endfunction()

# ringsplat_loads_images(TARGET folder...): in the build tree what it loads for images is beside it, too.
function(ringsplat_loads_images target)
  ringsplat_run_path(${target} "$ORIGIN" ${ARGN})
  add_custom_command(TARGET ${target} POST_BUILD VERBATIM COMMAND ${CMAKE_COMMAND} -E create_symlink
    $<TARGET_FILE:ringsplat_openimageio> $<TARGET_FILE_DIR:${target}>/$<TARGET_SONAME_FILE_NAME:ringsplat_openimageio>)
endfunction()

# ringsplat_program(TARGET room NAME library...): the program NAME of a room's main.cpp, which the room, then, is without.
function(ringsplat_program target room name)
  get_target_property(sources ringsplat_${room} SOURCES)
  list(FILTER sources EXCLUDE REGEX "/main\\.cpp$")
  set_target_properties(ringsplat_${room} PROPERTIES SOURCES "${sources}")
  add_executable(${target} ${room}/main.cpp)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_compile_options(${target} PRIVATE ${RINGSPLAT_WARNINGS})
  target_link_libraries(${target} PRIVATE ringsplat_${room} ${ARGN})
  set_target_properties(${target} PROPERTIES OUTPUT_NAME ${name})
  ringsplat_loads_images(${target} "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")
endfunction()
