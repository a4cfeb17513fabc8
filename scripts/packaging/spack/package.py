# Ringsplat for Spack (https://spack.io). Add it to a repository of packages of your own:
#
#   spack repo create ringsplat-repo && mkdir ringsplat-repo/packages/ringsplat
#   cp scripts/packaging/spack/package.py ringsplat-repo/packages/ringsplat/
#   spack repo add ringsplat-repo && cd ringsplat && spack dev-build ringsplat@0.1.0
from spack.package import *


class Ringsplat(CMakePackage):
    """Distributed volume rendering by token-ordered splatting on MPI ranks."""

    license("BSD-3-Clause", checked_by="the Ringsplat authors")

    # Sources come from where you got this file: spack dev-build, or spack develop --path.
    version("0.1.0")

    variant("mpi", default=True, description="Render on MPI ranks; without it in one process")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("ninja", type="build")
    depends_on("pkgconfig", type="build")

    depends_on("mpi", when="+mpi")
    depends_on("openimageio@2.4:")
    depends_on("gdcm@3:")
    depends_on("libtiff@4.5:")
    depends_on("hdf5@1.10.7:~mpi")
    depends_on("boost@1.74:")
    depends_on("libjpeg-turbo")
    depends_on("glm")
    depends_on("highway")
    depends_on("cli11")
    depends_on("nlohmann-json")
    depends_on("fmt")
    depends_on("tbb")
    depends_on("zlib-api")
    depends_on("expat")
    depends_on("lz4")
    depends_on("zstd")
    depends_on("c-blosc")
    depends_on("xz")
    depends_on("catch2", type="test")

    conflicts("%gcc@:11", msg="C++20 needs GCC 12 or later")
    conflicts("%clang@:13", msg="C++20 needs Clang 14 or later")

    generator("ninja")

    def cmake_args(self):
        return [
            self.define_from_variant("RINGSPLAT_WITH_MPI", "mpi"),
            self.define("RINGSPLAT_BUILD_TESTS", self.run_tests),
            self.define("RINGSPLAT_SIMULATION", "OFF"),
        ]
