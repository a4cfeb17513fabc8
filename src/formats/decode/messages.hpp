#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/archive.hpp"
#include "base/log.hpp"

#include "formats/stored_source.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/formats/open.hpp"

/// What a process and the program that decodes for it say to each other, over a socket. Voxels go through
/// memory that both share.
namespace ringsplat::detail {

enum class DecodedFormat : std::uint32_t { hdf5, tiff, dicom };

/// Descriptors that the program is started with.
inline constexpr int decode_socket = 3, decode_memory = 4;
/// Exit code of a program of another version, which its only argument names.
inline constexpr int other_version_code = 64;

struct DecodeRequest {
  enum class Kind : std::uint32_t {
    open,   ///< a volume
    read,   ///< `count` slices from `first` on, into the shared memory
    facts,  ///< VolumeSource::facts()
    close   ///< has no answer
  };
  Kind kind = Kind::open;
  std::uint32_t source = 0;  ///< its number; of one that is opened a new one
  int first = 0, count = 0;
  DecodedFormat format = DecodedFormat::hdf5;
  std::string folder = {}, path = {};  ///< the process's working folder, which a relative path begins at
  VolumeChoice choice = {};
};

/// A volume that was opened.
struct DecodedVolume {
  Grid grid;
  bool concurrent = true;
  int layer_depth = 1;
  VolumeNotes notes;
  std::optional<StoredVoxels> in_place;  ///< where the voxels lie in the file as they are
};

struct DecodeAnswer {
  struct LogLine {
    LogLevel level = LogLevel::warning;
    std::string text;
  };
  struct Failure {
    ExitCode code = ExitCode::bad_input;
    std::string what;  ///< with its hint
  };
  std::vector<LogLine> log = {};
  std::optional<Failure> failure = std::nullopt;
  DecodedVolume volume = {};  ///< when one was opened
  Facts facts = {};           ///< when they were asked for
};

constexpr DecodedFormat last_of(DecodedFormat) { return DecodedFormat::dicom; }
constexpr DecodeRequest::Kind last_of(DecodeRequest::Kind) { return DecodeRequest::Kind::close; }
constexpr Encoding last_of(Encoding) { return Encoding::text; }

/// Sends a message with its length before it; false when the other side is gone.
bool send_message(int socket, Bytes message);
/// Waits for the next one; nothing when the other side is gone.
std::optional<Bytes> receive_message(int socket);

}  // namespace ringsplat::detail

namespace ringsplat {

constexpr World last_of(World) { return World::microscope; }
constexpr ScalarType last_of(ScalarType) { return ScalarType::float64; }
constexpr LogLevel last_of(LogLevel) { return LogLevel::error; }
constexpr ExitCode last_of(ExitCode) { return ExitCode::run_failed; }

void fields(VolumeChoice& choice, auto& archive) {
  archive(choice.frame, choice.channel, choice.series, choice.memory);
}
void fields(detail::DecodeRequest& r, auto& archive) {
  archive(r.kind, r.source, r.first, r.count, r.format, r.folder, r.path, r.choice);
}
void fields(Grid& grid, auto& archive) {
  archive(grid.dims, grid.spacing, grid.origin, grid.direction, grid.type);
}
void fields(ChannelNotes& notes, auto& archive) {
  archive(notes.name, notes.colour, notes.window, notes.hidden);
}
void fields(VolumeNotes& notes, auto& archive) {
  archive(notes.world, notes.unit, notes.quantity, notes.modality, notes.fill, notes.labels, notes.frames,
          notes.channels, notes.of_channels, notes.series);
}
void fields(detail::StoredVoxels& stored, auto& archive) {
  archive(stored.file, stored.offset, stored.encoding, stored.skip, stored.end, stored.big_endian,
          stored.type, stored.half, stored.rescale);
}
void fields(detail::DecodedVolume& volume, auto& archive) {
  archive(volume.grid, volume.concurrent, volume.layer_depth, volume.notes, volume.in_place);
}
void fields(detail::DecodeAnswer::LogLine& line, auto& archive) { archive(line.level, line.text); }
void fields(detail::DecodeAnswer::Failure& failure, auto& archive) { archive(failure.code, failure.what); }
void fields(detail::DecodeAnswer& answer, auto& archive) {
  archive(answer.log, answer.failure, answer.volume, answer.facts);
}

}  // namespace ringsplat
