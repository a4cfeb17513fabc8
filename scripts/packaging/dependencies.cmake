# Every library the project uses, found once; scripts/setup.sh says what each is for.
find_package(Threads REQUIRED)
option(RINGSPLAT_WITH_MPI "Build the program and the library for MPI; OFF: for one process" ON)
if(RINGSPLAT_WITH_MPI)
  find_package(MPI COMPONENTS CXX)
  if(NOT MPI_CXX_FOUND)
    message(FATAL_ERROR "There is no MPI for C++ (Debian: libopenmpi-dev or libmpich-dev). Install one, name its compiler in "
      "MPI_CXX_COMPILER, or build for one process with -DRINGSPLAT_WITH_MPI=OFF.")
  endif()
endif()
find_package(glm CONFIG REQUIRED)
find_package(fmt CONFIG REQUIRED)
find_package(CLI11 CONFIG REQUIRED)
find_package(nlohmann_json CONFIG REQUIRED)
find_package(hwy CONFIG REQUIRED)
find_package(ZLIB REQUIRED)
find_package(EXPAT REQUIRED)
find_package(LibLZMA REQUIRED)
find_package(TBB CONFIG REQUIRED)
# Of Boost only headers, which installed libraries do not need: Beast and Asio, for the viewer's server, Math, and
# Locale's UTF-8.
find_package(Boost 1.74 REQUIRED)

# Debian's OpenImageIO CMake package names an include folder of another package
# (OpenEXR's Imath); pkg-config describes the same library without it.
find_package(PkgConfig REQUIRED)
pkg_check_modules(OpenImageIO REQUIRED IMPORTED_TARGET OpenImageIO)

# Blocks of VTK's XML files, and Zarr's chunks.
pkg_check_modules(LZ4 REQUIRED IMPORTED_TARGET liblz4)
pkg_check_modules(Zstd REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(Blosc REQUIRED IMPORTED_TARGET blosc)

# HDF5 without MPI: a build of it with another MPI than ours must not come into the process. Debian calls it
# hdf5-serial; elsewhere hdf5 may be either.
pkg_search_module(SerialHdf5 REQUIRED IMPORTED_TARGET hdf5-serial>=1.10.7 hdf5>=1.10.7)
find_file(RINGSPLAT_HDF5_CONFIGURATION H5pubconf.h HINTS ${SerialHdf5_INCLUDE_DIRS} REQUIRED)
file(STRINGS ${RINGSPLAT_HDF5_CONFIGURATION} parallel_hdf5 REGEX "^#define H5_HAVE_PARALLEL 1")
if(parallel_hdf5)
  message(FATAL_ERROR "${RINGSPLAT_HDF5_CONFIGURATION} is of an HDF5 built with MPI; install the serial one (Debian: libhdf5-dev)")
endif()

# DICOM. Debian's package lists programs of its own that nobody needs here, a page of status messages each time.
set(GDCM_SKIP_USE_VTK ON)
set(CMAKE_MESSAGE_LOG_LEVEL NOTICE)
find_package(GDCM REQUIRED)
unset(CMAKE_MESSAGE_LOG_LEVEL)
add_library(ringsplat_gdcm INTERFACE)
target_include_directories(ringsplat_gdcm SYSTEM INTERFACE ${GDCM_INCLUDE_DIRS})
target_link_libraries(ringsplat_gdcm INTERFACE gdcmMSFF)

# A TIFF's pages; OpenImageIO, which reads their pixels, does not tell where they lie.
pkg_check_modules(Tiff REQUIRED IMPORTED_TARGET libtiff-4>=4.5)

# The viewer's JPEGs.
pkg_check_modules(TurboJpeg REQUIRED IMPORTED_TARGET libturbojpeg)

# Simulated machines, where SimGrid is installed.
set(RINGSPLAT_SIMULATION AUTO CACHE STRING "Build the program for SimGrid's simulated MPI: ON, OFF or AUTO (when it is there)")
set(RINGSPLAT_SIMGRID_FOUND FALSE)
if(NOT RINGSPLAT_WITH_MPI)
  if(NOT RINGSPLAT_SIMULATION MATCHES "^(AUTO|OFF)$")
    message(FATAL_ERROR "RINGSPLAT_SIMULATION=${RINGSPLAT_SIMULATION} simulates MPI: it needs RINGSPLAT_WITH_MPI=ON")
  endif()
elseif(NOT RINGSPLAT_SIMULATION STREQUAL "OFF")
  pkg_check_modules(SimGrid QUIET IMPORTED_TARGET simgrid>=3.32)
  if(SimGrid_FOUND)
    pkg_get_variable(SimGrid_INCLUDEDIR simgrid includedir)
    set(RINGSPLAT_SIMGRID_FOUND TRUE)
  elseif(NOT RINGSPLAT_SIMULATION STREQUAL "AUTO")
    message(FATAL_ERROR "SimGrid 3.32 or later is missing (Debian: libsimgrid-dev)")
  endif()
endif()
