# Tests that mpirun starts on several ranks.
#
# add_mpi_test_program(TARGET SOURCES file... [LIBRARIES target...])
#   A Catch2 program whose main (support/mpi_main.cpp) starts MPI, lets rank 0 alone report, and
#   ends the job with the rank's name as soon as an assertion fails on any rank.
#
# add_mpi_test(TARGET NP count... [TIMEOUT seconds] [ARGS argument...])
#   One CTest entry TARGET_np<count> for each count.

if(RINGSPLAT_WITH_MPI)
  add_library(mpi_test_main OBJECT support/mpi_main.cpp)
  target_link_libraries(mpi_test_main PUBLIC Catch2::Catch2 MPI::MPI_CXX ringsplat_flags)
  target_include_directories(mpi_test_main PUBLIC ${CMAKE_CURRENT_SOURCE_DIR})
endif()

function(add_mpi_test_program target)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(${target} ${ARG_SOURCES})
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/src)
  target_compile_options(${target} PRIVATE ${RINGSPLAT_WARNINGS} ${RINGSPLAT_TEST_OPTIMISATION})
  target_precompile_headers(${target} REUSE_FROM test_headers)
  target_link_libraries(${target} PRIVATE mpi_test_main ${ARG_LIBRARIES})
endfunction()

# The launcher gives up a little before CTest does, so that it is the one that ends the ranks.
function(set_mpi_test_properties test ranks timeout)
  math(EXPR timeout "${timeout} * ${RINGSPLAT_PATIENCE}")
  math(EXPR grace "${timeout} + 15")
  set_tests_properties(${test} PROPERTIES
    PROCESSORS ${ranks}
    TIMEOUT ${grace}
    ENVIRONMENT "${RINGSPLAT_MPI_TEST_ENVIRONMENT};MPIEXEC_TIMEOUT=${timeout}")
endfunction()

function(add_mpi_test target)
  cmake_parse_arguments(ARG "" "TIMEOUT" "NP;ARGS" ${ARGN})
  if(NOT ARG_NP)
    message(FATAL_ERROR "add_mpi_test(${target}): NP names no number of ranks")
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  foreach(ranks IN LISTS ARG_NP)
    add_test(NAME ${target}_np${ranks}
             COMMAND ${MPIEXEC_EXECUTABLE} ${MPIEXEC_NUMPROC_FLAG} ${ranks} $<TARGET_FILE:${target}> ${ARG_ARGS})
    set_mpi_test_properties(${target}_np${ranks} ${ranks} ${ARG_TIMEOUT})
  endforeach()
endfunction()
