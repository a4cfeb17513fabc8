#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string_view>

struct NrrdIoState_t;

/// The files that an NRRD header's "data file" names, for example s%03d.raw 1 60 1.
namespace ringsplat::detail {

/// Throws InputError for headers that overflow NrrdIO's buffers: a data file pattern that is more than a name
/// with a number, which goes to sprintf; and long lines, which its error messages quote.
void require_nrrdio_can_read(const std::filesystem::path& header);

/// Calls `use(file, number of files)` for each of several files, in their order.
void for_data_files(const std::filesystem::path& header, const NrrdIoState_t& io,
                    const std::function<void(const std::filesystem::path&, std::uint64_t)>& use);

}  // namespace ringsplat::detail
