# Included when all rooms are known. ringsplat::ringsplat is the whole library: every room but the command
# line and its way to do without MPI, with what the rooms use.
include(CMakePackageConfigHelpers)
get_property(rooms GLOBAL PROPERTY RINGSPLAT_ROOMS)
list(REMOVE_ITEM rooms ringsplat_decode ringsplat_app ringsplat_command_line ringsplat_study ringsplat_program ringsplat_forecast ringsplat_options
     ringsplat_alone ringsplat_words)
add_library(ringsplat_library INTERFACE)
add_library(ringsplat::ringsplat ALIAS ringsplat_library)
set_target_properties(ringsplat_library PROPERTIES EXPORT_NAME ringsplat)
target_link_libraries(ringsplat_library INTERFACE ${rooms})

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/ringsplat)
set_target_properties(ringsplat_flags PROPERTIES EXPORT_NAME flags)
# Nine tenths of a release are information for debuggers, which stays in the build.
install(CODE [[
  if(NOT DEFINED CMAKE_INSTALL_DO_STRIP AND NOT CMAKE_INSTALL_CONFIG_NAME STREQUAL "Debug")
    set(CMAKE_INSTALL_DO_STRIP ON)
  endif()]])
install(TARGETS ringsplat_cli ringsplat_decode_program ringsplat_c)
install(TARGETS ringsplat_library ringsplat_flags ringsplat_openimageio ${rooms} EXPORT ringsplat-targets)
install(EXPORT ringsplat-targets NAMESPACE ringsplat:: DESTINATION ${package_folder})
set(left_out)
if(NOT RINGSPLAT_WITH_MPI)
  set(left_out PATTERN "ringsplat/mpi" EXCLUDE)
endif()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/ringsplat DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING PATTERN "*.hpp" PATTERN "*.h" ${left_out})
install(FILES ${PROJECT_SOURCE_DIR}/src/c/ringsplat.f90 DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ringsplat)
install(FILES ${PROJECT_BINARY_DIR}/include/ringsplat/config.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ringsplat)

configure_package_config_file(scripts/packaging/ringsplat-config.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/ringsplat-config.cmake
  INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/ringsplat-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/ringsplat-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/ringsplat-config-version.cmake
  DESTINATION ${package_folder})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/CHANGELOG.md
  DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES ${RINGSPLAT_MAN_PAGE} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(DIRECTORY ${RINGSPLAT_COMPLETIONS}/ DESTINATION ${CMAKE_INSTALL_DATADIR})
