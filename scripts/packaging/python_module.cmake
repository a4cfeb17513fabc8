# Whether Python's module is built, and for which MPI. scikit-build-core, which makes wheels, sets SKBUILD.
set(RINGSPLAT_PYTHON_MODULE AUTO CACHE STRING "Build Python's module: ON, OFF or AUTO (where nanobind, NumPy and Python's headers are)")
set(with_mpi ON)
if(SKBUILD)
  set(with_mpi OFF)
endif()
option(RINGSPLAT_PYTHON_MPI "Build Python's module for the ranks of an MPI communicator, too" ${with_mpi})
if(SKBUILD)
  set(RINGSPLAT_WITH_MPI ${RINGSPLAT_PYTHON_MPI} CACHE BOOL "Build the program and the library for MPI; OFF: for one process" FORCE)
endif()

set(RINGSPLAT_PYTHON_FOUND FALSE)
if(RINGSPLAT_PYTHON_MODULE STREQUAL "AUTO" AND CMAKE_CXX_FLAGS MATCHES "-fsanitize")
  # The interpreter would have to be started with the sanitizer's library.
elseif(NOT RINGSPLAT_PYTHON_MODULE STREQUAL "OFF")
  # The tests' environment has nanobind (tests/python/make.py).
  set(tests_python ${PROJECT_SOURCE_DIR}/build/python/venv/bin/python)
  if(NOT Python_EXECUTABLE AND NOT SKBUILD AND EXISTS ${tests_python})
    set(Python_EXECUTABLE ${tests_python})
  endif()
  find_package(Python 3.9 QUIET COMPONENTS Interpreter Development.Module)
  if(Python_FOUND)
    execute_process(COMMAND ${Python_EXECUTABLE} -c "import nanobind, nanobind.stubgen, numpy"
      RESULT_VARIABLE no_packages OUTPUT_QUIET ERROR_QUIET)
    if(no_packages EQUAL 0)
      set(RINGSPLAT_PYTHON_FOUND TRUE)
    endif()
  endif()
  if(NOT RINGSPLAT_PYTHON_FOUND AND NOT RINGSPLAT_PYTHON_MODULE STREQUAL "AUTO")
    message(FATAL_ERROR "Python's module needs Python 3.9 with its headers (Debian: python3-dev), nanobind and NumPy "
      "(pip install nanobind numpy, before 3.11 typing_extensions, too, or python3 tests/python/make.py build/python); "
      "Python_EXECUTABLE names another Python.")
  endif()
endif()
