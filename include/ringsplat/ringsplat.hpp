#pragma once
/// The header to start with: a Session renders a volume that lies in blocks on MPI ranks, or in one process.
#include "ringsplat/base/error.hpp"
#include "ringsplat/classify/transfer_function.hpp"
#include "ringsplat/config.hpp"
#include "ringsplat/formats/open.hpp"
#include "ringsplat/images/write_image.hpp"
#include "ringsplat/live/live.hpp"
#include "ringsplat/session/session.hpp"
#if RINGSPLAT_WITH_MPI
#include "ringsplat/mpi/communicator.hpp"
#endif
